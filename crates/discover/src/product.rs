//! `Aᵀ B` through the blocked kernel: the library's own takes one dot product at a time.

use nalgebra::{DMatrix, Dyn, Matrix, Storage};

/// `Aᵀ B`.
pub(crate) fn cross<A, B>(a: &Matrix<f64, Dyn, Dyn, A>, b: &Matrix<f64, Dyn, Dyn, B>) -> DMatrix<f64>
where
    A: Storage<f64, Dyn, Dyn>,
    B: Storage<f64, Dyn, Dyn>,
{
    /// Up to so many columns, dot products are faster than packing.
    const THIN: usize = 5;
    let (k, n) = (a.ncols(), b.ncols());
    let mut out = DMatrix::zeros(k, n);
    if k > THIN && n > THIN && a.nrows() > THIN {
        out.gemm(1.0, &a.transpose(), b, 0.0);
    } else {
        out.gemm_tr(1.0, a, b, 0.0);
    }
    out
}
