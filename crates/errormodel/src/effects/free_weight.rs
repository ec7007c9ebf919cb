//! Weights of links that nobody declared: where their first moments may point.
//!
//! ```text
//! Σ m_k (x_k − o) = Σ_k R_k h_k          h_k fixed in link k; what lies along a turning joint's axis is fixed in the link before
//! ```
//!
//! so that every link that turns has two numbers, across its axis, and a slide one, its own way.

use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Joint, JointId, JointKind, Posture};

/// How many numbers the link behind a joint has.
pub(in crate::effects) fn numbers(joint: &Joint) -> usize {
    if joint.kind == JointKind::Prismatic { 1 } else { 2 }
}

/// The directions of these numbers in the measurement frame; of a slide with its travel, m.
pub(in crate::effects) fn arms(at: &Posture<'_>, id: JointId) -> [Option<Vector3<f64>>; 2] {
    let chain = at.chain();
    let joint = chain.joint(id);
    let rotation = at.frame(chain.frame_after(id)).rotation;
    match joint.kind {
        JointKind::Prismatic => [Some(rotation * joint.axis_behind() * at.joint(id)), None],
        _ => across(joint).map(|arm| Some(rotation * arm)),
    }
}

/// Two unit vectors across a joint's axis, in the axes of its link.
pub(in crate::effects) fn across(joint: &Joint) -> [Vector3<f64>; 2] {
    let axis = joint.axis_behind();
    let mut other = Vector3::zeros();
    other[axis.iamin()] = 1.0;
    let first = axis.cross(&other).normalize();
    [first, axis.cross(&first)]
}
