//! All errors of one simulated robot, as numbers.

use crate::SimulateError;
use crate::physics::backlash::DeadBand;
use crate::physics::beam::Beam;
use crate::physics::bridge::{Bridge, Ram};
use crate::physics::changes::Change;
use crate::physics::coupling::Coupling;
use crate::physics::creep::Creep;
use crate::physics::foundation::Foundation;
use crate::physics::guideway::GuidewayProfile;
use crate::physics::heating::Heating;
use crate::physics::joint_stiffness::JointStiffness;
use crate::physics::linkage::FourBar;
use crate::physics::mounting::{LiftingFlange, TiltingBearing};
use crate::physics::presliding::Presliding;
use crate::physics::spring::GasSpring;
use crate::physics::transmission::TransmissionError;
use crate::physics::wave::LoadedWaves;
use crate::rigid::{Rigid, TakenApart};
use nalgebra::{Point3, Vector3};
use truepose_kinematics::{Chain, Joint, JointId, JointKind, Link, Placement};

/// The true errors of a robot. [`Truth::of`] is a robot without any error.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Constant displacement `[tx ty tz rx ry rz]` behind each frame, in its axes: base, joints, tool; m, rad.
    /// The rotation is a rotation vector.
    pub frames: Vec<[f64; 6]>,
    /// How far each target lies from where it is declared, tool axes, m.
    pub targets: Vec<Vector3<f64>>,
    /// The elastic foundation.
    pub foundation: Foundation,
    /// A base plate that lifts off under large moments.
    pub base_plate: Option<LiftingFlange>,
    /// Each joint and the link that it moves, fixed ones included.
    pub joints: Vec<JointTruth>,
    /// Changes with time.
    pub changes: Vec<Change>,
}

/// One joint as it is, and the link behind it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointTruth {
    /// Stiffness of drive and bearing.
    pub stiffness: JointStiffness,
    /// Errors of the linear guideway of a prismatic joint.
    pub guideway: Option<GuidewayProfile>,
    /// Transmission errors.
    pub transmission: Vec<TransmissionError>,
    /// Transmission errors whose amplitude follows the load.
    pub waves: Option<LoadedWaves>,
    /// Friction with memory; it acts in a campaign, whose order of poses is its path.
    pub presliding: Option<Presliding>,
    /// A bearing that tilts out of proportion.
    pub bearing: Option<TiltingBearing>,
    /// The link's flange behind the joint, which lifts off under large moments.
    pub flange: Option<LiftingFlange>,
    /// Backlash.
    pub backlash: Option<DeadBand>,
    /// A part of the travel in which backlash is worn: middle and half width, rad or m; all of it where there is none.
    pub worn: Option<[f64; 2]>,
    /// A late deflection; it acts in a campaign.
    pub creep: Option<Creep>,
    /// A joint that heats itself; it acts in a campaign.
    pub heating: Option<Heating>,
    /// The rail of a slide between its posts.
    pub bridge: Option<Bridge>,
    /// A slide that comes out of its bushes.
    pub ram: Option<Ram>,
    /// A spring that turns the joint beside its load; it acts through the stiffness of the drive.
    pub spring: Option<GasSpring>,
    /// A closed linkage that drives the joint.
    pub linkage: Option<FourBar>,
    /// Coupling to other joints.
    pub couplings: Vec<Coupling>,
    /// The link's true mass and centre.
    pub link: Option<Link>,
    /// The link as an elastic body; none is rigid.
    pub beam: Option<Beam>,
}

impl Truth {
    /// A robot that is exactly as described.
    pub fn of(chain: &Chain) -> Self {
        Truth {
            frames: vec![[0.0; 6]; chain.joints().len() + 2],
            targets: vec![Vector3::zeros(); chain.targets().len()],
            foundation: Foundation::default(),
            base_plate: None,
            joints: chain
                .joints()
                .iter()
                .map(|joint| JointTruth { link: joint.link, ..JointTruth::default() })
                .collect(),
            changes: Vec::new(),
        }
    }

    /// Checks that it has the size of this robot, and that constant errors and weights are finite.
    ///
    /// # Errors
    /// [`SimulateError::Shape`] names the list that has not, [`SimulateError::Size`] the number that is not.
    pub fn fits(&self, chain: &Chain) -> Result<(), SimulateError> {
        let n = chain.joints().len();
        let lists = [
            ("displaced frames", self.frames.len(), n + 2),
            ("displaced targets", self.targets.len(), chain.targets().len()),
            ("joints with errors", self.joints.len(), n),
        ];
        if let Some((what, have, need)) = lists.into_iter().find(|(_, have, need)| have != need) {
            return Err(SimulateError::Shape { what, have, need });
        }
        let links = self.joints.iter().filter_map(|joint| joint.link.as_ref());
        let numbers = (self.frames.iter().flatten().copied())
            .chain(self.targets.iter().flat_map(|off| off.iter().copied()))
            .chain(links.flat_map(|link| [link.mass, link.com.x, link.com.y, link.com.z]));
        match numbers.into_iter().find(|number| !number.is_finite()) {
            Some(value) => {
                Err(SimulateError::Size { what: "a constant error or a weight", value, need: "finite" })
            }
            None => Ok(()),
        }
    }
}

/// Where the link behind a joint begins and ends, in the axes of the frame after the joint: from the point about which
/// its joint moves to that of the next one that moves (or to the tool), all at their zero.
///
/// The point is where the description has it: the origin of the frame in front with standard DH, of the frame behind with MDH
/// and origin + axis; the carriage of a slide. A link whose ends are one point (in a wrist) is as long as the tool.
pub fn span(chain: &Chain, joint: JointId) -> (Vector3<f64>, Vector3<f64>) {
    let here = chain.joint(joint);
    let root = match here.placement {
        Placement::Dh { d, a, alpha, .. } => {
            // Rx(−α) takes (a, 0, d) from the axis' frame to the frame behind the link.
            let d = if here.kind == JointKind::Prismatic { 0.0 } else { d };
            let (s, c) = alpha.sin_cos();
            -Vector3::new(a, s * d, c * d)
        }
        Placement::Mdh { .. } | Placement::Origin { .. } => Vector3::zeros(),
    };
    let mut through = Rigid::identity();
    let mut tip = None;
    for next in &chain.joints()[joint.index() + 1..] {
        if next.kind != JointKind::Fixed {
            tip = Some(point_of(next));
            break;
        }
        let parts = TakenApart::of(next);
        through = through * parts.before * parts.motion(0.0) * parts.after;
    }
    let tip = (through * Point3::from(tip.unwrap_or(chain.tool().pose.translation))).coords;
    if (tip - root).norm() < 1e-6 { (root, root + chain.tool().pose.translation) } else { (root, tip) }
}

/// The point about which a joint moves seen from the frame in front of it, at its zero.
fn point_of(next: &Joint) -> Vector3<f64> {
    match next.placement {
        Placement::Dh { d, .. } if next.kind == JointKind::Prismatic => Vector3::new(0.0, 0.0, d),
        Placement::Dh { .. } => Vector3::zeros(),
        Placement::Mdh { alpha, a, d, .. } => {
            let (s, c) = alpha.sin_cos();
            Vector3::new(a, -s * d, c * d)
        }
        Placement::Origin { pose, .. } => pose.translation,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn a_link_reaches_from_its_axis_to_the_next() {
        // UR10 (DH): the upper arm's frame sits at the elbow; the shoulder lies 0.612 m along +x of it.
        let (root, tip) = span(&samples::ur10(), JointId(2));
        assert!((root - Vector3::new(0.612, 0.0, 0.0)).norm() < 1e-15 && tip.norm() < 1e-15);
        // Heavy (MDH): the upper arm of a2 reaches 1.1 m along x; the whole forearm lies behind a3; a4 and a5 meet.
        let (root, tip) = span(&samples::heavy(), JointId(2));
        assert!(root.norm() < 1e-15 && (tip - Vector3::new(1.1, 0.0, 0.0)).norm() < 1e-15);
        let (_, tip) = span(&samples::heavy(), JointId(3));
        assert!((tip - Vector3::new(-0.05, 1.15, 0.0)).norm() < 1e-15);
        let (_, tip) = span(&samples::heavy(), JointId(4));
        assert!((tip - Vector3::new(0.05, 0.0, 0.25)).norm() < 1e-15);
        // A fixed flange is a part of the link in front.
        let skewed = samples::skewed();
        let flange = TakenApart::of(skewed.joint(JointId(2)));
        let expected = flange.before * Point3::new(0.2, 0.0, 0.1);
        assert!((span(&skewed, JointId(1)).1 - expected.coords).norm() < 1e-15);
    }

    #[test]
    fn the_root_of_a_dh_link_lies_on_its_axis() {
        for chain in [samples::ur10(), samples::skewed()] {
            for (index, joint) in chain.joints().iter().enumerate() {
                if let Placement::Dh { .. } = joint.placement {
                    let (root, _) = span(&chain, JointId(index + 1));
                    let seen = TakenApart::of(joint).after * nalgebra::Point3::from(root);
                    assert!(seen.coords.norm() < 1e-15, "{} joint {}", chain.name(), index + 1);
                }
            }
        }
    }
}
