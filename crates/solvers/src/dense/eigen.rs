//! Eigenvectors of a symmetric matrix, M = V diag(λ) Vᵀ, λ smallest first.

use super::{copy_out, tame, tamed};
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, Par};
use nalgebra::DMatrix;

/// Eigenvalues, ascending, in the unit of the matrix, and orthonormal eigenvectors, n × n, column by column, of a symmetric n × n matrix. None where a number is not finite, or the iteration does
/// not converge.
pub fn symmetric_eigen(matrix: &DMatrix<f64>) -> Option<(Vec<f64>, DMatrix<f64>)> {
    let n = matrix.ncols();
    if n == 0 {
        return Some((Vec::new(), DMatrix::zeros(0, 0)));
    }
    if !matrix.iter().all(|v| v.is_finite()) {
        return None;
    }
    let by = tame(matrix);
    let (mut values, mut vectors) = (Diag::zeros(n), Mat::zeros(n, n));
    let need = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Default::default());
    self_adjoint_evd(
        tamed(matrix, by).as_ref(),
        values.as_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(need)),
        Default::default(),
    )
    .ok()?;
    Some((values.column_vector().iter().map(|value| value / by).collect(), copy_out(vectors.as_ref())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rebuilds_the_matrix_at_any_scale() {
        for (n, scale) in [(0, 1.0), (1, 1.0), (6, 1e-200), (40, 1.0), (90, 1e150)] {
            let half = DMatrix::from_fn(n, n, |i, j| ((i * 3 + j * j) as f64).sin());
            let matrix = (&half + half.transpose()) * scale;
            let (values, vectors) = symmetric_eigen(&matrix).unwrap();
            let mut scaled = vectors.clone();
            scaled.column_iter_mut().zip(&values).for_each(|(mut column, value)| column *= *value / scale);
            let error = scaled * vectors.transpose() - &matrix / scale;
            assert!(error.norm() < 1e-13 * (1.0 + n as f64), "{n}: {}", error.norm());
            assert!((vectors.tr_mul(&vectors) - DMatrix::identity(n, n)).norm() < 1e-13 * (1.0 + n as f64));
            assert!(values.is_sorted());
        }
        assert!(symmetric_eigen(&DMatrix::from_element(3, 3, f64::NAN)).is_none());
    }
}
