//! Joints as people read them: degrees and mm, as the controller has them.

use truepose_kinematics::{Chain, JointId};

/// Joint values in degrees and mm.
pub(super) fn in_units(chain: &Chain, joints: &[f64]) -> Vec<f64> {
    let unit = |joint: &JointId| if chain.joint(*joint).unit() == "m" { 1e3 } else { 1f64.to_degrees() };
    // As the controller has them.
    let mut joints = joints.to_vec();
    chain.joints_to_controller(&mut joints);
    chain.movable().iter().zip(joints).map(|(joint, value)| value * unit(joint)).collect()
}

/// Names of the joints with degrees or mm.
pub(super) fn joint_names(chain: &Chain) -> Vec<String> {
    let name = |joint: &JointId| {
        let joint = chain.joint(*joint);
        format!("{}, {}", joint.name, if joint.unit() == "m" { "mm" } else { "°" })
    };
    chain.movable().iter().map(name).collect()
}
