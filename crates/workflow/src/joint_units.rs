//! Joints as people read them: degrees and mm, as the controller has them.

use truepose_io::Unit;
use truepose_kinematics::{Chain, JointId};

/// Units of what is written.
#[derive(Debug, Clone, Copy, Default)]
pub struct Units {
    /// Of lengths.
    pub length: Option<Unit>,
    /// Of angles.
    pub angle: Option<Unit>,
}

/// The chosen units of the joints; where none was chosen for a joint, the usual one.
pub fn chosen(chain: &Chain, usual: &[Unit], units: &Units) -> Vec<Unit> {
    let one = |(joint, usual): (&JointId, &Unit)| {
        let chosen = if chain.joint(*joint).unit() == "m" { units.length } else { units.angle };
        chosen.unwrap_or(*usual)
    };
    chain.movable().iter().zip(usual).map(one).collect()
}

/// Units in memory.
pub fn si(chain: &Chain) -> Vec<Unit> {
    let quantity = |joint: &JointId| match chain.joint(*joint).unit() {
        "m" => truepose_io::Quantity::Length,
        _ => truepose_io::Quantity::Angle,
    };
    chain.movable().iter().map(|joint| *quantity(joint).si()).collect()
}

/// Joint values in degrees and mm.
pub fn in_units(chain: &Chain, joints: &[f64]) -> Vec<f64> {
    let unit = |joint: &JointId| if chain.joint(*joint).unit() == "m" { 1e3 } else { 1f64.to_degrees() };
    // As the controller has them.
    let mut joints = joints.to_vec();
    chain.joints_to_controller(&mut joints);
    let own = chain.movable().iter().zip(joints).enumerate().filter(|(k, _)| chain.is_commanded(*k));
    own.map(|(_, (joint, value))| value * unit(joint)).collect()
}

/// Names of the joints with degrees or mm.
pub fn joint_names(chain: &Chain) -> Vec<String> {
    let name = |joint: &JointId| {
        let joint = chain.joint(*joint);
        format!("{}, {}", joint.name, if joint.unit() == "m" { "mm" } else { "°" })
    };
    chain
        .movable()
        .iter()
        .enumerate()
        .filter(|(k, _)| chain.is_commanded(*k))
        .map(|(_, joint)| name(joint))
        .collect()
}
