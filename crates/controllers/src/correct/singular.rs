//! Postures near a singularity.
//!
//! ```text
//! h = ‖J(q)⁺ (J(q') − J(q))‖₂                                             refused where h > 1/2
//! ```
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | q, q' | nominal joints, joints of the correction | n | rad, or m by the arm's length |
//! | J | Jacobian of the nominal tool, lengths by the arm's length | 6 × n | 1 |
//! | h | Kantorovich's quantity, with the change of J that the correction makes in place of its bound | 1 | 1 |
//!
//! Up to 1/2 Newton's method from q converges to q', the only joints near q (affine-invariant Newton–Kantorovich theorem: Deuflhard, *Newton
//! Methods for Nonlinear Problems*, 2004, section 2.1): the correction is in the configuration of the nominal joints, and has the size of the
//! error. Near a singularity a small error turns joints far, and J(q)⁺ is large: h grows with the square.

use truepose_kinematics::nalgebra::DMatrix;
use truepose_kinematics::{Chain, Conditions, JointKind, PostureBuffer, joint_jacobian};

/// Largest h.
const KANTOROVICH: f64 = 0.5;

/// Singular values below this share of the largest are zero: round-off of a chain of metres.
const ZERO: f64 = 1e-9;

/// # Errors
/// In words, where the correction leaves the neighbourhood of the nominal joints.
pub(super) fn singular(
    chain: &Chain,
    buffer: &mut PostureBuffer,
    nominal: &[f64],
    corrected: &[f64],
) -> Result<(), String> {
    let at = jacobian(chain, buffer, nominal);
    let there = jacobian(chain, buffer, corrected);
    let steps = corrected.iter().zip(nominal).map(|(a, b)| (a - b).abs());
    let most = steps.fold(0.0, f64::max);
    let svd = at.clone().svd(true, true);
    let largest = svd.singular_values.max();
    let rank = svd.singular_values.iter().filter(|value| **value > ZERO * largest).count();
    if rank < svd.singular_values.len() {
        return Err("it is near a singularity: a joint turns without an effect of its own".into());
    }
    let Ok(inverse) = svd.pseudo_inverse(ZERO * largest) else {
        return Err("it is near a singularity".into());
    };
    let change = (inverse * (there - at)).singular_values().max();
    if change > KANTOROVICH {
        return Err(format!(
            "it is near a singularity: the correction moves a joint by {:.2}° (h = {change:.2}, at most {KANTOROVICH})",
            most.to_degrees()
        ));
    }
    Ok(())
}

/// Lengths by the arm's length; of fewer than six joints the position alone.
fn jacobian(chain: &Chain, buffer: &mut PostureBuffer, joints: &[f64]) -> DMatrix<f64> {
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
    let rows = if joints.len() >= 6 { 6 } else { joints.len().min(3) };
    jacobian.rows(0, rows).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn the_same_error_is_fine_away_from_a_singularity_and_refused_near_it() {
        let chain = samples::heavy();
        let mut buffer = PostureBuffer::new(&chain);
        // Two milliradians of the tool about the axis that the wrist lacks at zero: axis 4 turns by 2e-3 / sin q5.
        for (wrist, fine) in [(0.8, true), (0.3, true), (0.02, false), (0.0, false)] {
            let nominal = [0.2, -1.2, 1.1, 0.3, wrist, 0.4];
            let mut corrected = nominal;
            let turn = (2e-3 / f64::sin(wrist)).min(1.0);
            corrected[3] += turn;
            corrected[5] -= turn * f64::cos(wrist);
            assert_eq!(singular(&chain, &mut buffer, &nominal, &corrected).is_ok(), fine, "{wrist}");
        }
    }
}
