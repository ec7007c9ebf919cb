//! The directions of a candidate of which the present model leaves enough to be judged.

use nalgebra::{DMatrix, SymmetricEigen};
use truepose_solvers::kernels::symmetric_eigen;

/// ‖X‖² of a whitened column below which it is rounding: a hundred expected sizes of it move all observations together by less than a
/// ten-thousandth of their noise. The load of an upright axis is such a column, and its powers leave the range of single precision.
const NOTHING: f64 = 1e-12;

/// T with `Tᵀ (left) T = 1`, over directions of which enough is left.
pub(crate) fn basis(raw: &DMatrix<f64>, left: &DMatrix<f64>, absorbed: f64) -> Option<DMatrix<f64>> {
    let scale: Vec<f64> =
        raw.diagonal().iter().map(|&v| if v > NOTHING { 1.0 / v.sqrt() } else { 0.0 }).collect();
    scale.first()?;
    let k = scale.len();
    if k == 1 {
        let share = left[(0, 0)] * scale[0] * scale[0];
        return (share > absorbed).then(|| DMatrix::from_element(1, 1, scale[0] / share.sqrt()));
    }
    let scaled = DMatrix::from_fn(k, k, |i, j| left[(i, j)] * scale[i] * scale[j]);
    let (values, vectors) = eigen(scaled)?;
    let kept: Vec<usize> = (0..k).filter(|&i| values[i] > absorbed).collect();
    if kept.is_empty() {
        return None;
    }
    let mut basis = vectors.select_columns(&kept);
    for (column, &i) in kept.iter().enumerate() {
        let length = values[i].sqrt();
        for row in 0..k {
            basis[(row, column)] *= scale[row] / length;
        }
    }
    Some(basis)
}

/// −m ln(1 − SS/RSS) of m observations.
pub(crate) fn gain(observations: usize, squares: f64, rss: f64) -> f64 {
    -(observations as f64) * (1.0 - (squares / rss).min(1.0 - 1e-12)).ln()
}

/// Eigenvalues and eigenvectors of a symmetric matrix by what is faster for its size; none of one that is not finite.
fn eigen(matrix: DMatrix<f64>) -> Option<(Vec<f64>, DMatrix<f64>)> {
    /// Up to so many columns nalgebra's rotations are faster than faer's blocks.
    const SMALL: usize = 32;
    if matrix.ncols() > SMALL {
        return symmetric_eigen(&matrix);
    }
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(matrix);
    Some((eigenvalues.as_slice().to_vec(), eigenvectors))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    #[test]
    fn a_column_of_rounding_is_no_direction() {
        // What the square of the load of an upright axis is, in double precision; its square is nothing in single precision.
        let raw = DMatrix::from_diagonal(&DVector::from_row_slice(&[1e-40, 4.0]));
        let found = basis(&raw, &raw, 1e-3).unwrap();
        assert_eq!(found.ncols(), 1);
        assert!(found[(0, 0)].abs() < 1e-12 && (found[(1, 0)].abs() - 0.5).abs() < 1e-12, "{found}");
        let alone = raw.view((0, 0), (1, 1)).into_owned();
        assert!(basis(&alone, &alone, 1e-3).is_none());
    }

    #[test]
    fn small_and_large_blocks_have_a_basis_of_the_same_kind() {
        for k in [2, 31, 32, 33, 50] {
            let x = DMatrix::from_fn(3 * k, k, |i, j| ((i * 7 + j * 13 + i * j) as f64 * 0.37).sin());
            let mut left = x.tr_mul(&x);
            let raw = left.clone();
            // One direction is absorbed.
            let taken = left.column(0) * left.row(0) / left[(0, 0)];
            left -= taken;
            let found = basis(&raw, &left, 1e-6).unwrap();
            assert_eq!(found.ncols(), k - 1);
            let error = found.tr_mul(&left) * &found - DMatrix::identity(k - 1, k - 1);
            assert!(error.amax() < 1e-9, "{k}: {}", error.amax());
        }
    }
}
