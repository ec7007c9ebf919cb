//! Covariance of a predicted position from that of the coefficients, for commands that must not allocate.

use nalgebra::{DMatrix, Matrix3, Vector3};

/// `J C Jᵀ` of the first three rows of J (6 × p), m², without allocating.
///
/// ```text
/// J C Jᵀ = Σ_k C_kk j_k j_kᵀ + l_k j_kᵀ + j_k l_kᵀ,   l_k = Σ_{i<k} C_ik j_i
/// ```
pub(super) fn position_covariance(rows: &DMatrix<f64>, covariance: &DMatrix<f64>) -> Matrix3<f64> {
    let (columns, _) = rows.as_slice().as_chunks::<6>();
    let mut sum = Matrix3::zeros();
    for (k, column) in columns.iter().enumerate() {
        let right = Vector3::new(column[0], column[1], column[2]);
        if right == Vector3::zeros() {
            continue;
        }
        let own = &covariance.as_slice()[k * columns.len()..][..k];
        let left = before(own, columns);
        let mixed = left * right.transpose();
        sum += mixed + mixed.transpose() + right * right.transpose() * covariance[(k, k)];
    }
    sum
}

/// Σ_i C_ik j_i over the first columns, in four sums that a processor makes side by side.
fn before(own: &[f64], columns: &[[f64; 6]]) -> Vector3<f64> {
    let mut sums = [[0.0; 3]; 4];
    let mut add = |at: usize, c: f64, j: &[f64; 6]| (0..3).for_each(|d| sums[at][d] += c * j[d]);
    let (fours, last) = own.as_chunks::<4>();
    for (c, j) in fours.iter().zip(columns.as_chunks::<4>().0) {
        (0..4).for_each(|at| add(at, c[at], &j[at]));
    }
    last.iter().zip(&columns[4 * fours.len()..]).enumerate().for_each(|(at, (c, j))| add(at, *c, j));
    Vector3::from_fn(|d, _| sums.iter().map(|sum| sum[d]).sum())
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
