//! The fitted geometry as joint origins, in the robot's own base: what a URDF or a controller's kinematics file holds.
//!
//! ```text
//! base link = B E_0,   origin of joint 1 = pre_1,   origin of joint i+1 = post_i E_i pre_{i+1},   tool = post_n E_n tool E_tool
//! ```
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | B E_0 | `base` | pose | m | measurement |
//! | origin | `joints` | pose | m | of the joint in the frame of the one before, at q = 0 |
//! | tool | `tool` | pose | m | of the tool in the last joint's frame |
//!
//! `E_0` is the installation of the robot and no error of the arm: it is in `base`, and never in a joint.

use super::geometry::corrected_chain;
use super::options::ExportOptions;
use super::remaining::Exported;
use crate::CompensateError;
use nalgebra::{Unit, Vector3};
use truepose_errormodel::FittedModel;
use truepose_kinematics::{Chain, Joint, Link, Placed, Placement, Pose, Target};

/// A joint's origin, and its axis there.
#[derive(Debug, Clone, PartialEq)]
pub struct JointOrigin {
    /// The joint's name.
    pub name: String,
    /// Pose of the joint's frame in the one before, at q = 0.
    pub pose: Pose,
    /// Unit direction of the axis in the joint's frame.
    pub axis: Unit<Vector3<f64>>,
    /// Its link, the centre of mass in the joint's frame.
    pub link: Option<Link>,
}

/// The robot as origins.
#[derive(Debug, Clone, PartialEq)]
pub struct JointOrigins {
    /// Measurement frame to the robot's base link.
    pub base: Pose,
    /// One a joint, fixed ones included.
    pub joints: Vec<JointOrigin>,
    /// The frame in front of each tool, the last joint's of most robots, to the tool.
    pub tools: Vec<Pose>,
    /// The targets, m, in the tool's axes.
    pub targets: Vec<Vector3<f64>>,
}

impl JointOrigins {
    /// The robot of these origins, with names, limits and gravity of the one given.
    ///
    /// # Errors
    /// When the given robot has other joints.
    pub fn to_chain(&self, like: &Chain) -> Result<Chain, CompensateError> {
        let joints = like.joints().iter().zip(&self.joints).map(|(described, origin)| Joint {
            placement: Placement::Origin { pose: origin.pose, axis: origin.axis },
            link: origin.link,
            ..described.clone()
        });
        let tools: Vec<Placed> = self.tools.iter().map(|&pose| Placed { pose, known: true }).collect();
        Ok(Chain::new(like.name(), joints.collect())?
            .coupled_as(like)?
            .branched_as(like)?
            .with_base(Placed { pose: self.base, known: true })?
            .with_placed_tools(&tools)?
            .with_gravity(*like.gravity())?
            .with_targets(placed(like, &self.targets))?)
    }
}

/// The targets of a robot at these places, m.
pub(super) fn placed(like: &Chain, targets: &[Vector3<f64>]) -> Vec<Target> {
    let both = like.targets().iter().zip(targets);
    both.map(|(target, &position)| Target { position, ..target.clone() }).collect()
}

/// The fitted geometry as origins of the joints.
///
/// # Errors
/// When the conditions do not fit the model.
pub fn joint_origins(
    fitted: &FittedModel,
    options: &ExportOptions,
) -> Result<Exported<JointOrigins>, CompensateError> {
    let Exported { value: chain, left_out, remaining_error, comparison } = corrected_chain(fitted, options)?;
    let base = chain.base().pose;
    let mut joints = Vec::with_capacity(chain.joints().len());
    for joint in chain.joints() {
        let (pose, axis) = match joint.placement {
            Placement::Origin { pose, axis } => (pose, axis),
            // A corrected chain has origins alone.
            _ => (joint.transform(0.0), Vector3::z_axis()),
        };
        joints.push(JointOrigin { name: joint.name.clone(), pose, axis, link: joint.link });
    }
    let targets = chain.targets().iter().map(|target| target.position).collect();
    let tools = chain.tools().iter().map(|tool| tool.placed.pose).collect();
    let value = JointOrigins { base, joints, tools, targets };
    Ok(Exported { value, left_out, remaining_error, comparison })
}
