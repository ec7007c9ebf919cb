//! Substitution with the leading n × n upper triangle of R.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_inverse::invert_upper_triangular;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector};

/// x with R x = b, on the leading n = b.len() rows and columns.
pub(crate) fn solve_upper(r: &DMatrix<f64>, b: &[f64]) -> DVector<f64> {
    let mut x = DVector::from_column_slice(b);
    for j in (0..b.len()).rev() {
        x[j] /= r[(j, j)];
        let xj = x[j];
        for i in 0..j {
            x[i] -= r[(i, j)] * xj;
        }
    }
    x
}

/// x with Rᵀ x = b, on the leading n = b.len() rows and columns.
pub(crate) fn solve_upper_transposed(r: &DMatrix<f64>, b: &[f64]) -> DVector<f64> {
    let mut x = DVector::from_column_slice(b);
    for j in 0..b.len() {
        let known: f64 = (0..j).map(|i| r[(i, j)] * x[i]).sum();
        x[j] = (x[j] - known) / r[(j, j)];
    }
    x
}

/// x with L x = b, on the leading n = b.len() rows and columns of a lower triangle.
pub(crate) fn solve_lower(l: &DMatrix<f64>, b: &[f64]) -> DVector<f64> {
    let mut x = DVector::from_column_slice(b);
    for j in 0..b.len() {
        x[j] /= l[(j, j)];
        let xj = x[j];
        let below = &l.as_slice()[j * l.nrows()..][..b.len()];
        x.as_mut_slice()[j + 1..].iter_mut().zip(&below[j + 1..]).for_each(|(x, l)| *x -= l * xj);
    }
    x
}

/// x with Lᵀ x = b.
pub(crate) fn solve_lower_transposed(l: &DMatrix<f64>, b: &[f64]) -> DVector<f64> {
    let mut x = DVector::from_column_slice(b);
    for j in (0..b.len()).rev() {
        let below = &l.as_slice()[j * l.nrows()..][..b.len()];
        let known: f64 = x.as_slice()[j + 1..].iter().zip(&below[j + 1..]).map(|(x, l)| x * l).sum();
        x[j] = (x[j] - known) / l[(j, j)];
    }
    x
}

/// (RᵀR)⁻¹ = R⁻¹ R⁻ᵀ of an upper triangle without zeros on its diagonal.
pub(crate) fn inverse_gram(r: &DMatrix<f64>) -> DMatrix<f64> {
    let n = r.ncols();
    let triangle = MatRef::from_column_major_slice(r.as_slice(), n, n);
    let mut inverse = Mat::zeros(n, n);
    invert_upper_triangular(inverse.as_mut(), triangle, Par::Seq);
    let mut product = DMatrix::zeros(n, n);
    let into = MatMut::from_column_major_slice_mut(product.as_mut_slice(), n, n);
    matmul(into, Accum::Replace, inverse.as_ref(), inverse.transpose(), 1.0, Par::Seq);
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways() {
        let r = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, -1.0, 0.0, 3.0, 0.5, 0.0, 0.0, 4.0]);
        let b = [1.0, 2.0, 3.0];
        assert!((&r * solve_upper(&r, &b) - DVector::from_column_slice(&b)).norm() < 1e-15);
        assert!(
            (r.transpose() * solve_upper_transposed(&r, &b) - DVector::from_column_slice(&b)).norm() < 1e-15
        );
        let l = r.transpose();
        assert!((&l * solve_lower(&l, &b) - DVector::from_column_slice(&b)).norm() < 1e-15);
        assert!((&r * solve_lower_transposed(&l, &b) - DVector::from_column_slice(&b)).norm() < 1e-15);
    }
}
