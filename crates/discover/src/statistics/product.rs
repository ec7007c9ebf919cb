//! Products of tall matrices through the blocked kernel.

use nalgebra::{Cholesky, DMatrix, Dyn};
use truepose_solvers::kernels;
pub(crate) use truepose_solvers::kernels::product;

/// `Aᵀ B`.
pub(crate) fn cross(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    /// Up to so many columns, dot products are faster than packing.
    const THIN: usize = 5;
    if a.ncols() <= THIN || b.ncols() <= THIN || a.nrows() <= THIN {
        return a.tr_mul(b);
    }
    kernels::cross(a, b)
}

/// `AᵀA`.
pub(crate) fn gram_matrix(a: &DMatrix<f64>) -> DMatrix<f64> {
    /// Up to so many columns, both halves are computed as fast as one.
    const THIN: usize = 12;
    let n = a.ncols();
    if n <= THIN {
        return cross(a, a);
    }
    let mut out = DMatrix::zeros(n, n);
    kernels::gram(&mut out, a);
    out.fill_upper_triangle_with_lower_triangle();
    out
}

/// L of a symmetric positive definite matrix, `L Lᵀ`; none of one that is not, to rounding.
pub(crate) fn cholesky(matrix: DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    let n = matrix.ncols();
    kernels::cholesky_lower(matrix, n).map(Cholesky::pack_dirty)
}

/// An orthonormal basis of the columns: `Q = A L⁻ᵀ`, `L Lᵀ = AᵀA`, twice (CholeskyQR2: Yamamoto et al. 2015), which is orthogonal to
/// rounding as long as the scaled columns are independent to 1e-6; by Householder reflections else.
pub(crate) fn orthonormal(a: DMatrix<f64>) -> DMatrix<f64> {
    const INDEPENDENT: f64 = 1e-6;
    if a.ncols() == 0 {
        return a;
    }
    match by_cholesky(&a, INDEPENDENT).and_then(|q| by_cholesky(&q, INDEPENDENT)) {
        Some(q) => q,
        None => a.qr().q(),
    }
}

/// An orthonormal basis of columns that are orthogonal to each other but for rounding.
pub(crate) fn orthonormal_again(a: DMatrix<f64>) -> DMatrix<f64> {
    /// Least pivot of the scaled columns for which one pass leaves rounding alone.
    const ORTHOGONAL: f64 = 0.9;
    if a.ncols() == 0 {
        return a;
    }
    by_cholesky(&a, ORTHOGONAL).unwrap_or_else(|| orthonormal(a))
}

/// `A L⁻ᵀ`, `L Lᵀ = AᵀA`; none where a pivot of the scaled columns is not above `least`.
fn by_cholesky(a: &DMatrix<f64>, least: f64) -> Option<DMatrix<f64>> {
    let n = a.ncols();
    let gram = gram_matrix(a);
    let size: Vec<f64> = gram.diagonal().iter().map(|v| v.sqrt()).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| gram[(i, j)] / (size[i] * size[j]));
    let lower = cholesky(scaled)?.unpack();
    if !lower.diagonal().iter().all(|&d| d > least) {
        return None;
    }
    let mut inverse = DMatrix::identity(n, n);
    kernels::solve_lower_many(&lower, &mut inverse);
    let mut inverse = inverse.transpose();
    for (i, size) in size.iter().enumerate() {
        inverse.row_mut(i).scale_mut(1.0 / size);
    }
    Some(product(a, &inverse))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gram_matrix_is_that_of_all_products() {
        for (rows, columns) in [(30, 5), (40, 13), (200, 49), (90, 131)] {
            let a = DMatrix::from_fn(rows, columns, |i, j| ((i * 7 + j * 13) as f64).sin());
            assert!((gram_matrix(&a) - a.transpose() * &a).amax() < 1e-11, "{rows} x {columns}");
            assert_eq!(gram_matrix(&a), gram_matrix(&a).transpose());
        }
    }

    #[test]
    fn a_basis_is_orthonormal_and_spans_the_columns() {
        for tilt in [1.0, 1e-3, 1e-9] {
            // Two columns that differ by `tilt`, on scales far apart.
            let a = DMatrix::from_fn(30, 7, |i, j| {
                let t = (i as f64 + 1.0) * 0.37;
                let wave = (t * (j.min(5) as f64 + 1.0)).sin();
                10f64.powi(3 * j as i32 - 9) * if j == 6 { wave + tilt * t.cos() } else { wave }
            });
            let q = orthonormal(a.clone());
            let bent = &q + 1e-3 * DMatrix::from_fn(30, 7, |i, j| ((i * j) as f64).cos());
            for q in [&q, &orthonormal_again(bent), &orthonormal_again(a.clone())] {
                assert!((cross(q, q) - DMatrix::identity(7, 7)).amax() < 1e-13);
            }
            for j in 0..7 {
                let column = a.column(j).into_owned();
                let left = &column - &q * q.tr_mul(&column);
                assert!(left.norm() < 1e-13 * column.norm() / tilt.min(1e-3), "{tilt} {j} {}", left.norm());
            }
        }
    }
}
