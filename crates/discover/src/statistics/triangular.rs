//! Substitution with many right-hand sides: in blocks of rows, so that nearly all of it is products.
//!
//! ```text
//! L X = B:   X_i = L_ii⁻¹ (B_i − Σ_{j<i} L_ij X_j)
//! ```

use nalgebra::DMatrix;

/// Rows of a block.
const BLOCK: usize = 32;

/// `L⁻¹ B`, in place; of L only the lower triangle is read.
pub(crate) fn solve_lower(lower: &DMatrix<f64>, b: &mut DMatrix<f64>) {
    let columns = b.ncols();
    substitute(lower, b, |_| columns);
}

/// `L⁻¹`; of L only the lower triangle is read.
pub(crate) fn inverse_lower(lower: &DMatrix<f64>) -> DMatrix<f64> {
    let n = lower.nrows();
    let mut inverse = DMatrix::identity(n, n);
    // Above the diagonal it is zero.
    substitute(lower, &mut inverse, |end| end);
    inverse
}

/// `columns`: how many are not zero in the rows before this one.
fn substitute(lower: &DMatrix<f64>, b: &mut DMatrix<f64>, columns: impl Fn(usize) -> usize) {
    let n = b.nrows();
    for first in (0..n).step_by(BLOCK) {
        let size = BLOCK.min(n - first);
        let mut part = b.columns_mut(0, columns(first + size));
        let (done, mut own) = part.rows_range_pair_mut(0..first, first..first + size);
        if first > 0 {
            own.gemm(-1.0, &lower.view((first, 0), (size, first)), &done, 1.0);
        }
        let mut triangle = DMatrix::identity(size, size);
        lower.view((first, first), (size, size)).solve_lower_triangular_mut(&mut triangle);
        let left = own.clone_owned();
        own.gemm(1.0, &triangle, &left, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::synthetic::wave;

    /// A triangle with something else above it.
    fn triangle(n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |i, j| match i == j {
            true => 1.0 + wave(i).abs(),
            false => 0.2 * wave(31 * i + 17 * j),
        })
    }

    #[test]
    fn it_is_substitution_column_by_column() {
        for (n, m) in [(3, 5), (32, 40), (75, 200), (130, 1)] {
            let lower = triangle(n);
            let b = DMatrix::from_fn(n, m, |i, j| wave(7 * i + 3 * j));
            let (mut expected, mut found) = (b.clone(), b);
            lower.solve_lower_triangular_mut(&mut expected);
            solve_lower(&lower, &mut found);
            assert!((found - &expected).amax() < 1e-11 * expected.amax(), "{n} x {m}");
        }
    }

    #[test]
    fn an_inverse_is_one() {
        for n in [1, 31, 100] {
            let lower = triangle(n);
            let inverse = inverse_lower(&lower);
            assert!(
                (&inverse - inverse.lower_triangle()).amax() < f64::MIN_POSITIVE,
                "zero above the diagonal"
            );
            assert!((lower.lower_triangle() * inverse - DMatrix::identity(n, n)).amax() < 1e-12);
        }
    }
}
