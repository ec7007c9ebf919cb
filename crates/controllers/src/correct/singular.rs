//! Postures near a singularity.
//!
//! ```text
//! refused where 4 δ > σ²                                Kantorovich: β K η ≤ 1/2 with β = 1/σ, η = δ/σ, K = 2
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | δ | error of the real robot at the nominal joints: position by the arm's length, and angle | rad |
//! | σ | smallest singular value of the Jacobian, lengths by the arm's length | 1 |
//! | K | Lipschitz constant of that Jacobian: unit axes, distances up to twice the length | 1/rad |
//!
//! Where the condition holds, Newton's method from the nominal joints stays in their configuration, and the correction of the joints is of
//! the size of the error (Kantorovich 1948).

use truepose_kinematics::{Chain, Conditions, JointKind, Pose, PostureBuffer, joint_jacobian, rotation_log};

/// # Errors
/// In words, where the posture is near a singularity; poses are of the real robot and the desired one.
pub(super) fn singular(
    chain: &Chain,
    buffer: &mut PostureBuffer,
    joints: &[f64],
    [real, desired]: [&Pose; 2],
    oriented: bool,
) -> Result<(), String> {
    let length = chain.characteristic_length();
    let conditions = Conditions::at(chain, joints);
    let posture = buffer.update(chain, &conditions);
    let mut jacobian = joint_jacobian(&posture, &posture.tool().translation.clone());
    for (column, joint) in chain.movable().iter().enumerate() {
        if chain.joint(*joint).kind == JointKind::Prismatic {
            jacobian.column_mut(column).scale_mut(length);
        }
    }
    jacobian.rows_mut(0, 3).scale_mut(1.0 / length);
    let rows = if oriented { 6 } else { jacobian.ncols().min(3) };
    let values = jacobian.rows(0, rows).svd(false, false).singular_values;
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let turned =
        if oriented { rotation_log(&(real.rotation * desired.rotation.transpose())).norm() } else { 0.0 };
    let error = ((real.translation - desired.translation).norm() / length).hypot(turned);
    if 4.0 * error > smallest * smallest {
        return Err(format!(
            "it is near a singularity: smallest singular value {smallest:.4} where the correction needs {:.4}",
            (4.0 * error).sqrt()
        ));
    }
    Ok(())
}
