//! Covariance of a predicted position from that of the coefficients, for commands that must not allocate.

use nalgebra::{DMatrix, Matrix3, Vector3};

/// `J C Jᵀ` of the first three rows of J (6 × p), m², without allocating.
pub(super) fn position_covariance(rows: &DMatrix<f64>, covariance: &DMatrix<f64>) -> Matrix3<f64> {
    let row = |k: usize| Vector3::new(rows[(0, k)], rows[(1, k)], rows[(2, k)]);
    let mut sum = Matrix3::zeros();
    for (k, column) in covariance.column_iter().enumerate() {
        let right = row(k);
        if right == Vector3::zeros() {
            continue;
        }
        let left: Vector3<f64> = column.iter().enumerate().map(|(i, c)| row(i) * *c).sum();
        sum += left * right.transpose();
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_product_of_the_matrices() {
        let mut draw = 1u64;
        let mut next = |_: usize, _: usize| {
            draw = draw.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (draw >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        let root = DMatrix::from_fn(9, 9, &mut next);
        let covariance = &root * root.transpose();
        let mut rows = DMatrix::from_fn(6, 9, &mut next);
        rows.column_mut(4).fill(0.0);
        let product = rows.rows(0, 3) * &covariance * rows.rows(0, 3).transpose();
        let found = position_covariance(&rows, &covariance);
        assert!((found - Matrix3::from_iterator(product.iter().copied())).norm() < 1e-13 * product.norm());
    }
}
