//! Sizes in metres and per newton metre, for a robot of any size.
//!
//! Expected sizes of slides, guideways, play and stiffness are those of machines that people build and stand beside. A robot in another
//! unit of length, or one that is a thousand times as small, has the same errors in proportion: lengths grow with the robot, and torques of
//! the same weights as well, so that a compliance per torque shrinks with it.

use truepose_kinematics::Chain;

/// Characteristic lengths of machines for which sizes are taken as they stand, m: a desktop arm, and a gantry in a hall.
const USUAL: [f64; 2] = [0.1, 30.0];

/// How much larger the robot is than a usual one: 1 for those of [`USUAL`], in proportion to its length beyond.
pub(super) fn robot_size(chain: &Chain) -> f64 {
    let length = chain.characteristic_length();
    length / length.clamp(USUAL[0], USUAL[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Effect;
    use crate::effects::{Backlash, BaseCompliance, JointCompliance, LoadNonlinearity, Side};
    use truepose_kinematics::{Joint, JointId, Placement, samples};

    /// All lengths of a robot times a factor.
    fn scaled(chain: &Chain, factor: f64) -> Chain {
        let joint = |joint: &Joint| {
            let mut joint = joint.clone();
            match &mut joint.placement {
                Placement::Dh { d, a, .. } | Placement::Mdh { d, a, .. } => {
                    (*d, *a) = (*d * factor, *a * factor)
                }
                Placement::Origin { pose, .. } => pose.translation *= factor,
            }
            joint
        };
        Chain::new(chain.name().to_owned(), chain.joints().iter().map(joint).collect()).unwrap()
    }

    #[test]
    fn expected_sizes_are_in_proportion_to_the_robot() {
        for chain in samples::all() {
            assert!((robot_size(&chain) - 1.0).abs() < 1e-12, "{} is of no usual size", chain.name());
        }
        let arm = samples::ur10();
        let (small, large) = (scaled(&arm, 1e-3), scaled(&arm, 1e3));
        assert!((robot_size(&large) / robot_size(&small)).log10() > 3.0);
        let size = |effect: &dyn Fn(&Chain) -> f64| effect(&large) / effect(&small);
        let (joint, ratio) = (JointId(2), robot_size(&large) / robot_size(&small));
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        close(size(&|c| JointCompliance::of(joint).columns(c)[0].scale), 1.0 / ratio);
        close(size(&|c| BaseCompliance::default().columns(c)[0].scale), 1.0 / ratio);
        close(size(&|c| LoadNonlinearity::with_powers(joint, vec![3]).columns(c)[0].scale), ratio.powi(-3));
        close(size(&|c| Backlash::of(joint, Side::Approach).columns(c)[0].scale), 1.0);
    }
}
