//! How well a set of postures determines constant errors: no data, no fit, no Jacobian in memory.
//!
//! ```text
//! d_k² = eigenvalues of D (Σ J_pᵀJ_p / σ_p² + Σ J_φᵀJ_φ / σ_φ²) D,   D = diag(expected sizes)
//! ```
//!
//! The errors of neighbouring frames do in part the same: their matrix has fewer directions than columns, and those that are left say what
//! can be told apart. Square roots of eigenvalues know nothing below 1e-7 of the largest; what is below counts as undetermined.

use crate::IdentifyError;
use crate::observability::indices;
use serde::{Deserialize, Serialize};
use truepose_errormodel::lanes::JacobianGram;
use truepose_kinematics::nalgebra::{DMatrix, SymmetricEigen};

/// Share of the largest singular value that rounding can feign.
const UNDETERMINED: f64 = 1e-7;

/// Scales of [`posture_observability`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PostureScales {
    /// Standard deviation of one component of a measured position, m.
    pub position_sd: f64,
    /// Of one component of a measured orientation, rad; infinite where positions alone are measured.
    pub orientation_sd: f64,
    /// Expected size of an error of length, m.
    pub length: f64,
    /// Expected size of an error of angle, rad.
    pub angle: f64,
}

impl Default for PostureScales {
    /// Positions to 0.1 mm, no orientations; errors of 1 mm and 1 mrad.
    fn default() -> Self {
        PostureScales { position_sd: 1e-4, orientation_sd: f64::INFINITY, length: 1e-3, angle: 1e-3 }
    }
}

/// Indices O1–O5 of the directions that are determined ([`crate::Observability`] has their formulas).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PostureObservability {
    /// Number of postures.
    pub postures: usize,
    /// Singular values of the directions that are determined, largest first.
    pub singular_values: Vec<f64>,
    /// O1 to O5, larger is better.
    pub indices: [f64; 5],
    /// Of the weakest of them, the share of each column: six a joint's frame, x, y, z, rx, ry, rz.
    pub weakest: Vec<f64>,
}

/// Of the postures of these sums.
///
/// # Errors
/// [`IdentifyError::Option`] when a scale is not positive, or a length, an angle or the standard deviation of positions is not finite.
pub fn posture_observability(
    gram: &JacobianGram,
    scales: PostureScales,
) -> Result<PostureObservability, IdentifyError> {
    let PostureScales { position_sd, orientation_sd, length, angle } = scales;
    for (what, value, finite) in [
        ("position_sd", position_sd, true),
        ("orientation_sd", orientation_sd, false),
        ("length", length, true),
        ("angle", angle, true),
    ] {
        if value.is_nan() || value <= 0.0 || (finite && value.is_infinite()) {
            return Err(IdentifyError::Option { option: what, value, expected: "positive" });
        }
    }
    let size = |column: usize| if column % 6 < 3 { length } else { angle };
    let whitened = gram.whitened(position_sd, orientation_sd);
    let columns = whitened.nrows();
    let scaled = DMatrix::from_fn(columns, columns, |i, j| size(i) * whitened[(i, j)] * size(j));
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(scaled);
    let mut order: Vec<usize> = (0..columns).collect();
    order.sort_by(|&a, &b| eigenvalues[b].total_cmp(&eigenvalues[a]).then(a.cmp(&b)));
    let largest = order.first().map_or(0.0, |&first| eigenvalues[first].max(0.0));
    let seen =
        |&column: &usize| eigenvalues[column] > 0.0 && eigenvalues[column] > UNDETERMINED.powi(2) * largest;
    order.retain(seen);
    let singular_values: Vec<f64> = order.iter().map(|&column| eigenvalues[column].sqrt()).collect();
    let weakest =
        order.last().map(|&column| eigenvectors.column(column).iter().map(|share| share * share).collect());
    Ok(PostureObservability {
        postures: gram.postures(),
        indices: indices(&singular_values, gram.postures()),
        singular_values,
        weakest: weakest.unwrap_or_default(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::lanes::{LANES, error_jacobians};
    use truepose_kinematics::samples;

    fn joints(postures: usize) -> Vec<Vec<f64>> {
        (0..6).map(|k| (0..postures).map(|row| 1.7 * ((row * (k + 3) + k) as f64).sin()).collect()).collect()
    }

    #[test]
    fn singular_values_are_those_of_the_stacked_matrix() {
        let chain = samples::ur10();
        let joints = joints(40);
        let slices: Vec<&[f64]> = joints.iter().map(Vec::as_slice).collect();
        let gram = JacobianGram::of(&chain, &slices).expect("sizes fit");
        for orientation_sd in [f64::INFINITY, 2e-4] {
            let scales = PostureScales { orientation_sd, ..PostureScales::default() };
            let found = posture_observability(&gram, scales).expect("scales are positive");
            let mut into = vec![0.0; 36 * 6 * LANES];
            error_jacobians(&chain, &slices, &mut into).expect("sizes fit");
            // Sizes of lengths and angles are 1e-3 both.
            let stacked = DMatrix::from_fn(6 * 40, 36, |row, site| {
                let sd = if row % 6 < 3 { 1e-4 } else { orientation_sd };
                into[(6 * site + row % 6) * LANES + row / 6] * 1e-3 / sd
            });
            let mut values: Vec<f64> = stacked.singular_values().iter().copied().collect();
            values.sort_by(|a, b| b.total_cmp(a));
            let kept = found.singular_values.len();
            for (found, value) in found.singular_values.iter().zip(&values) {
                assert!((found / value - 1.0).abs() < 1e-6, "{found} {value}");
            }
            assert!(values[kept..].iter().all(|&value| value < 1e-12 * values[0]), "{:?}", &values[kept..]);
            let [.., o2, o3, o4, o5] = found.indices;
            let (first, last) = (values[0], values[kept - 1]);
            let sum: f64 = values[..kept].iter().map(|d| 1.0 / d).sum();
            for (found, expected) in
                [(o2, last / first), (o3, last), (o4, last * last / first), (o5, 1.0 / sum)]
            {
                assert!((found / expected - 1.0).abs() < 1e-6);
            }
            assert!((found.weakest.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn one_posture_determines_what_it_shows() {
        let chain = samples::ur10();
        let joints = joints(1);
        let slices: Vec<&[f64]> = joints.iter().map(Vec::as_slice).collect();
        let gram = JacobianGram::of(&chain, &slices).expect("sizes fit");
        let of = |orientation_sd| {
            let scales = PostureScales { orientation_sd, ..PostureScales::default() };
            posture_observability(&gram, scales).map(|found| found.singular_values.len())
        };
        assert_eq!(of(f64::INFINITY).expect("scales"), 3);
        assert_eq!(of(1e-4).expect("scales"), 6);
        assert!(of(0.0).is_err() && of(f64::NAN).is_err());
        let none = JacobianGram::of(&chain, &[&[][..]; 6]).expect("sizes fit");
        let none = posture_observability(&none, PostureScales::default()).expect("scales");
        assert!(none.singular_values.is_empty() && none.indices.iter().all(|o| *o < f64::MIN_POSITIVE));
    }
}
