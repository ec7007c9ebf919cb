//! The joint Jacobian: how a point moves when the joints do.
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | J | result | 6 × movable joints | m or rad per rad or m | measurement |
//!
//! Column j is `[z × (p − o); z]` for a turn about z through o, and `[z; 0]` for a slide along z; zero of a joint that does not carry the
//! tool.

use crate::{JointKind, Posture};
use nalgebra::{DMatrix, Vector3};

/// Jacobian of a point fixed to the tool (given in the measurement frame, m) and of the tool's orientation,
/// by the movable joints. Rows `[tx ty tz rx ry rz]` in the axes of the measurement frame.
pub fn joint_jacobian(posture: &Posture<'_>, point: &Vector3<f64>) -> DMatrix<f64> {
    let chain = posture.chain();
    let mut jacobian = DMatrix::zeros(6, chain.movable().len());
    for (column, &joint) in chain.movable().iter().enumerate() {
        let Some(motion) = chain.joint_motion(joint) else { continue };
        if !chain.carries(chain.frame_after(joint), posture.conditions().tool) {
            continue;
        }
        let at = posture.frame(motion.frame);
        let axis = at.rotation * motion.axis;
        match motion.kind {
            JointKind::Prismatic => jacobian.fixed_view_mut::<3, 1>(0, column).copy_from(&axis),
            _ => {
                jacobian.fixed_view_mut::<3, 1>(0, column).copy_from(&axis.cross(&(point - at.translation)));
                jacobian.fixed_view_mut::<3, 1>(3, column).copy_from(&axis);
            }
        }
    }
    jacobian
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Conditions, PostureBuffer, rotation_log, samples};

    #[test]
    fn agrees_with_differences_for_every_sample_robot() {
        for chain in samples::all() {
            let n = chain.movable().len();
            let joints: Vec<f64> = (0..n).map(|k| 0.2 - 0.3 * k as f64).collect();
            let conditions = Conditions::at(&chain, &joints);
            let mut buffer = PostureBuffer::new(&chain);
            let posture = buffer.update(&chain, &conditions);
            let jacobian = joint_jacobian(&posture, &posture.tool().translation.clone());
            for k in 0..n {
                let at = |d: f64| {
                    let mut q = joints.clone();
                    q[k] += d;
                    chain.forward(&q)
                };
                let (plus, minus) = (at(1e-6), at(-1e-6));
                let p = (plus.translation - minus.translation) / 2e-6;
                let r = rotation_log(&(plus.rotation * minus.rotation.transpose())) / 2e-6;
                for row in 0..3 {
                    assert!((jacobian[(row, k)] - p[row]).abs() < 1e-8, "{} {k}", chain.name());
                    assert!((jacobian[(row + 3, k)] - r[row]).abs() < 1e-8, "{} {k}", chain.name());
                }
            }
        }
    }
}
