//! Substitution with the leading n × n upper triangle of R.

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
    }
}
