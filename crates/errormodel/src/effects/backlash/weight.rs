//! The side on which the weight of the links behind lays a joint, where no weights are declared.
//!
//! ```text
//! a · (p − o) × g,   p = o + n + λ (e − n)
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | a, o | unit axis of the joint, a point on it | 1, m | measurement frame |
//! | g | gravity | m/s² | measurement frame |
//! | n, e | from the axis, across it, to the first joint behind it that is not on it; to the end of the arm | m | measurement frame |
//! | λ | where the centre of mass p is taken to be: an upper arm and a forearm of equal, uniform mass have 1/3 | 1 | |

use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, JointId, JointKind, Posture};

/// Nearer to the axis than this, m, a joint's origin says nothing about where its link lies.
const ON_AXIS: f64 = 1e-3;

/// Whether joint `k` is this one, or one that it moves.
fn follows(chain: &Chain, k: JointId, joint: JointId) -> bool {
    let (mut frame, goal) = (Some(chain.frame_after(k)), chain.frame_after(joint));
    while let Some(here) = frame {
        if here == goal {
            return true;
        }
        frame = chain.parent(here);
    }
    false
}

/// The moment about the axis, per mass, that gravity exerts on the assumed centre of mass of what a joint moves, m²/s²; a slide's: along it, m/s².
pub(super) fn moment(at: &Posture<'_>, joint: JointId, center: f64) -> f64 {
    let chain = at.chain();
    let Some(motion) = chain.joint_motion(joint) else { return 0.0 };
    let frame = at.frame(motion.frame);
    let (axis, gravity) = (frame.rotation * motion.axis, chain.gravity_in_measurement_frame());
    if motion.kind == JointKind::Prismatic {
        return axis.dot(&gravity);
    }
    let behind = chain.movable().iter().filter(|&&k| k >= joint && follows(chain, k, joint));
    let levers = behind.map(|&k| {
        let away = at.frame(chain.frame_after(k)).translation - frame.translation;
        away - axis * axis.dot(&away)
    });
    let (mut near, mut end) = (None, Vector3::zeros());
    for lever in levers {
        if near.is_none() && lever.norm() > ON_AXIS {
            near = Some(lever);
        }
        end = lever;
    }
    near.map_or(0.0, |near| axis.dot(&(near + (end - near) * center).cross(&gravity)))
}

#[cfg(test)]
mod tests {
    use crate::Effect;
    use crate::effects::{Backlash, Side};
    use crate::testkit::emitted;
    use truepose_kinematics::nalgebra::Vector3;
    use truepose_kinematics::{Conditions, JointId, Load, Payload, samples};

    #[test]
    fn an_assumed_centre_of_mass_lays_the_joint_where_a_payload_there_does() {
        let chain = samples::ur10();
        let load = Load::Payload(Payload { mass: 5.0, com: Vector3::zeros() });
        let mut turned = 0;
        for row in 0..200 {
            let q: Vec<f64> =
                (0..6).map(|k| 2.0 * ((row * (7 + 4 * k)) as f64 * 0.37 + k as f64).sin()).collect();
            let conditions = Conditions::at(&chain, &q).with_load(load);
            let side = |effect: Backlash| -> f64 {
                emitted(&effect, &chain, &conditions).iter().map(|e| e.value).sum()
            };
            for joint in [JointId(2), JointId(3)] {
                // A payload in the origin of the flange is a centre of mass at the end of the arm.
                let (assumed, known) = (Backlash::by_weight(joint, 1.0), Backlash::of(joint, Side::Load));
                assert!((side(assumed.clone()) - side(known)).abs() < 1e-15);
                turned += usize::from((side(assumed) - side(Backlash::by_weight(joint, 0.2))).abs() > 0.5);
            }
            // A vertical axis has no side.
            assert!(side(Backlash::by_weight(JointId(1), 0.5)).abs() < 1e-15);
        }
        assert!(turned > 20, "{turned}");
        let refused = |effect: Backlash| Effect::validate(&effect, &chain).unwrap_err().to_string();
        assert!(refused(Backlash::by_weight(JointId(2), 0.0)).contains("`center` has to be positive"));
        assert!(refused(Backlash::of(JointId(2), Side::Weight)).contains("needs `center`"));
    }
}
