//! The dense kernels, all on faer and all sequential, so that results do not depend on the number of threads. Nothing
//! else in the workspace names faer.

mod cholesky;
mod eigen;
mod householder;
mod leaf;
mod norm;
mod pivoted;
mod pivoted_cholesky;
mod singular;
mod triangle;

pub(crate) use cholesky::{cholesky, gram_of, gram_of_rows, residual_of_rows};
pub use cholesky::{cholesky_lower, cross, gram, product, solve_lower_many, solve_upper_many};
pub use eigen::symmetric_eigen;
pub(crate) use householder::{Reflectors, fold};
pub(crate) use norm::norm;
pub(crate) use pivoted::{ordered_qr, pivoted_qr};
pub(crate) use pivoted_cholesky::{PivotedCholesky, pivoted_cholesky};
pub(crate) use singular::{singular_values, svd};
pub(crate) use triangle::{
    inverse_gram, solve_lower, solve_lower_transposed, solve_upper, solve_upper_transposed,
};

use faer::{Mat, MatRef};
use nalgebra::DMatrix;

/// Zeros whose memory the system hands out as such: what is never written costs nothing.
pub(crate) fn zeros(rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_vec(rows, columns, vec![0.0; rows * columns])
}

fn copy_out(m: MatRef<'_, f64>) -> DMatrix<f64> {
    DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)])
}

/// A power of two that brings the largest entry near 1, so that faer neither overflows nor underflows.
fn tame(m: &DMatrix<f64>) -> f64 {
    let top = m.amax();
    if top > 0.0 && top.is_finite() { (-top.log2().floor()).clamp(-1020.0, 1020.0).exp2() } else { 1.0 }
}

fn tamed(m: &DMatrix<f64>, by: f64) -> Mat<f64> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * by)
}
