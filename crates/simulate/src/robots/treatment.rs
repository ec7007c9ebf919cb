//! The treatment point, from three measured targets.
//!
//! ```text
//! R, t = argmin Σ |R p_k + t − y_k|²        NTP = R p_NTP + t
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | p_k | declared positions of the targets | m | tool |
//! | y_k | `seen` | m | measurement |
//! | p_NTP | [`TREATMENT_POINT`] | m | tool |
//!
//! Source: Kabsch, *A solution for the best rotation to relate two sets of vectors* (1976).

use crate::{SimulateError, TREATMENT_POINT};
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::Chain;

/// Where the treatment point is, when the chain's targets were seen at these positions (measurement frame, m).
///
/// # Errors
/// [`SimulateError::Shape`] unless there is one position for each target and at least three.
pub fn treatment_point(chain: &Chain, seen: &[Vector3<f64>]) -> Result<Vector3<f64>, SimulateError> {
    let declared: Vec<Vector3<f64>> = chain.targets().iter().map(|target| target.position).collect();
    if seen.len() != declared.len() || seen.len() < 3 {
        let need = declared.len().max(3);
        return Err(SimulateError::Shape { what: "seen targets", have: seen.len(), need });
    }
    let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let (middle, middle_seen) = (mean(&declared), mean(seen));
    let cross: Matrix3<f64> =
        declared.iter().zip(seen).map(|(p, y)| (y - middle_seen) * (p - middle).transpose()).sum();
    let svd = cross.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return Err(SimulateError::Shape { what: "singular vectors", have: 0, need: 3 });
    };
    let handed = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v_t).determinant().signum()));
    let rotation = u * handed * v_t;
    Ok(rotation * (Vector3::from(TREATMENT_POINT) - middle) + middle_seen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;
    use truepose_kinematics::samples;

    #[test]
    fn it_moves_with_the_couch() {
        let chain = samples::pps();
        let turn = Rotation3::new(Vector3::new(0.3, -1.1, 0.2));
        let shift = Vector3::new(0.4, -0.1, 2.0);
        let seen: Vec<Vector3<f64>> = chain.targets().iter().map(|t| turn * t.position + shift).collect();
        let expected = turn * Vector3::from(TREATMENT_POINT) + shift;
        assert!((treatment_point(&chain, &seen).expect("a point") - expected).norm() < 1e-14);
        assert!(treatment_point(&chain, &seen[..2]).is_err());
    }
}
