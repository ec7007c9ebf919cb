//! Covariance of a predicted position from that of the coefficients, for commands that must not allocate.

use nalgebra::{DMatrix, Matrix3, Vector3};
use truepose_kinematics::pulp::{Arch, Simd, WithSimd};

/// C of the coefficients that the data determines, and room for what they do to a position.
#[derive(Debug, Clone)]
pub(super) struct PositionSpread {
    /// The r coefficients with a variance.
    known: Vec<usize>,
    /// r × r.
    covariance: DMatrix<f64>,
    /// For each of x, y and z what a unit of each of them does, 3 × r, axis after axis.
    axes: Vec<f64>,
    arch: Arch,
}

impl PositionSpread {
    pub fn new(covariance: &DMatrix<f64>) -> Self {
        let known: Vec<usize> = (0..covariance.nrows()).filter(|&k| covariance[(k, k)] != 0.0).collect();
        let covariance = covariance.select_rows(&known).select_columns(&known);
        PositionSpread { axes: vec![0.0; 3 * known.len()], known, covariance, arch: Arch::new() }
    }

    /// `J C Jᵀ` of the first three rows of J (6 × p), m², without allocating.
    ///
    /// ```text
    /// J C Jᵀ = Σ_k C_kk j_k j_kᵀ + l_k j_kᵀ + j_k l_kᵀ,   l_k = Σ_{i<k} C_ik j_i
    /// ```
    pub fn of(&mut self, rows: &DMatrix<f64>) -> Matrix3<f64> {
        let count = self.known.len();
        let (columns, _) = rows.as_slice().as_chunks::<6>();
        for (at, &column) in self.known.iter().enumerate() {
            (0..3).for_each(|axis| self.axes[axis * count + at] = columns[column][axis]);
        }
        self.arch.dispatch(Products { covariance: self.covariance.as_slice(), axes: &self.axes, count })
    }
}

struct Products<'a> {
    covariance: &'a [f64],
    axes: &'a [f64],
    count: usize,
}

impl WithSimd for Products<'_> {
    type Output = Matrix3<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Matrix3<f64> {
        let Products { covariance, axes, count } = self;
        let axis = |of: usize| &axes[of * count..][..count];
        let [x, y, z] = [axis(0), axis(1), axis(2)];
        let mut sum = Matrix3::zeros();
        for k in 0..count {
            let right = Vector3::new(x[k], y[k], z[k]);
            if right == Vector3::zeros() {
                continue;
            }
            let own = &covariance[k * count..][..=k];
            let left = before(simd, &own[..k], [&x[..k], &y[..k], &z[..k]]);
            let mixed = left * right.transpose();
            sum += mixed + mixed.transpose() + right * right.transpose() * own[k];
        }
        sum
    }
}

/// Σ_i C_ik j_i, of each axis in two sums that a processor makes side by side.
#[inline(always)]
fn before<S: Simd>(simd: S, own: &[f64], axes: [&[f64]; 3]) -> Vector3<f64> {
    let (own, own_rest) = S::as_simd_f64s(own);
    let whole = axes.map(|axis| S::as_simd_f64s(axis).0);
    let rest = axes.map(|axis| S::as_simd_f64s(axis).1);
    let mut sums = [[simd.splat_f64s(0.0); 2]; 3];
    for (at, &c) in own.iter().enumerate() {
        for (sums, axis) in sums.iter_mut().zip(&whole) {
            sums[at % 2] = simd.mul_add_f64s(c, axis[at], sums[at % 2]);
        }
    }
    Vector3::from_fn(|d, _| {
        let last: f64 = own_rest.iter().zip(rest[d]).map(|(c, j)| c * j).sum();
        simd.reduce_sum_f64s(simd.add_f64s(sums[d][0], sums[d][1])) + last
    })
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
        let mut root = DMatrix::from_fn(29, 29, &mut next);
        // A coefficient that was left out.
        root.row_mut(7).fill(0.0);
        let covariance = &root * root.transpose();
        let mut rows = DMatrix::from_fn(6, 29, &mut next);
        rows.column_mut(4).fill(0.0);
        let product = rows.rows(0, 3) * &covariance * rows.rows(0, 3).transpose();
        let found = PositionSpread::new(&covariance).of(&rows);
        assert!((found - Matrix3::from_iterator(product.iter().copied())).norm() < 1e-13 * product.norm());
    }
}
