//! `Aᵀ B` through the blocked kernel: the library's own takes one dot product at a time.

use nalgebra::{DMatrix, Dim, Matrix, RawStorage};

/// `Aᵀ B`.
pub(crate) fn cross<R1, C1, S1, R2, C2, S2>(
    a: &Matrix<f64, R1, C1, S1>,
    b: &Matrix<f64, R2, C2, S2>,
) -> DMatrix<f64>
where
    R1: Dim,
    C1: Dim,
    S1: RawStorage<f64, R1, C1>,
    R2: Dim,
    C2: Dim,
    S2: RawStorage<f64, R2, C2>,
{
    let (m, k, n) = (a.nrows(), a.ncols(), b.ncols());
    debug_assert_eq!(m, b.nrows());
    let left = DMatrix::from_fn(k, m, |i, j| a[(j, i)]);
    let right = DMatrix::from_fn(m, n, |i, j| b[(i, j)]);
    left * right
}
