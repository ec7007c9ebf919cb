//! The rigid motion that brings attained positions nearest to the commanded ones.
//!
//! ```text
//! min_{R, t} Σ ‖R a_i + t − c_i‖²        R = V diag(1, 1, det V Uᵀ) Uᵀ of the singular value decomposition U S Vᵀ of Σ (a_i − ā)(c_i − c̄)ᵀ
//! ```
//!
//! Source: Kabsch 1976; Umeyama 1991 for the sign.

use crate::error::AcceptanceError;
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::Pose;

/// Of pairs (attained, commanded), m.
///
/// # Errors
/// With fewer than three pairs, or with all on one line.
pub fn best_fit(pairs: &[(Vector3<f64>, Vector3<f64>)]) -> Result<Pose, AcceptanceError> {
    let few = AcceptanceError::Alignment { poses: pairs.len() };
    if pairs.len() < 3 {
        return Err(few);
    }
    let n = pairs.len() as f64;
    let attained = pairs.iter().map(|p| p.0).sum::<Vector3<f64>>() / n;
    let commanded = pairs.iter().map(|p| p.1).sum::<Vector3<f64>>() / n;
    let product: Matrix3<f64> = pairs.iter().map(|(a, c)| (a - attained) * (c - commanded).transpose()).sum();
    let svd = product.svd(true, true);
    let mut values: Vec<f64> = svd.singular_values.iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    // On one line the rotation about it is free; a thousandth of the extent (squared) is no second direction.
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Err(few) };
    if values[1] <= 1e-6 * values[0] {
        return Err(few);
    }
    let sign = (v_t.transpose() * u.transpose()).determinant().signum();
    // The reflection goes to the smallest singular value.
    let smallest = svd.singular_values.imin();
    let mut flip = Matrix3::identity();
    flip[(smallest, smallest)] = sign;
    let rotation = v_t.transpose() * flip * u.transpose();
    Ok(Pose::new(rotation, commanded - rotation * attained))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moved_plane_of_points_is_brought_back() {
        let motion = Pose::from_xyz_rpy([3.0, -2.0, 0.7], [0.3, -1.2, 2.5]);
        let points = [[0.0, 0.0, 0.0], [0.4, 0.0, 0.1], [0.4, 0.3, 0.1], [0.0, 0.3, 0.0]].map(Vector3::from);
        let pairs = points.map(|p| (motion.inverse().apply(&p), p));
        let found = best_fit(&pairs).unwrap();
        for (a, c) in pairs {
            assert!((found.apply(&a) - c).norm() < 1e-14);
        }
        assert!((found.rotation.determinant() - 1.0).abs() < 1e-12);
        assert!(best_fit(&pairs[..2]).is_err());
        let line = [0.0, 1.0, 2.0].map(|x| (Vector3::x() * x, Vector3::x() * x));
        assert!(best_fit(&line).is_err());
    }
}
