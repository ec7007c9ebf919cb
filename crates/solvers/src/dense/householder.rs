//! Folding a block of rows into a triangle: the step of a tall-skinny QR.
//!
//! Qᵀ [T Z; B C] = [T' Z'; 0 C'],  Q = I − V S Vᵀ,  V = [I; V_B]
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | T, Z | triangle so far and its right-hand sides | p × p, p × k |
//! | B, C | new rows of the matrix and of its right-hand sides | b × p, b × k |
//! | V_B | lower part of the Householder vectors; their upper part is the identity | b × p |
//! | S | upper triangular factor of the compact form | panel × panel |
//!
//! Source: Elmroth and Gustavson (2000), recursive QR; Demmel, Grigori, Hoemmen and Langou (2012), TSQR. faer's own QR
//! is not used here because it zeroes columns that are dependent to 16·m·ε, which would take the decision of the rank
//! out of our hands (at 200 000 rows that is 7e-10), and because the triangle's zeros save work.
//! The diagonal is normalised to ≥ 0, so that the triangle is a function of AᵀA alone.

use super::leaf::{PANEL, leaf};
use faer::linalg::matmul::matmul;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// Columns that are reflected one by one, at most; fewer where they would not stay in the nearest cache.
const LEAF: usize = 12;
const NEAR: usize = 4096;

/// Work space of [`fold`], kept between calls.
#[derive(Debug, Clone)]
pub(crate) struct Reflectors {
    factor: Mat<f64>,
    product: Mat<f64>,
    turned: Mat<f64>,
}

impl Default for Reflectors {
    fn default() -> Self {
        Self { factor: Mat::new(), product: Mat::new(), turned: Mat::new() }
    }
}

impl Reflectors {
    fn reserve(&mut self, columns: usize) {
        if self.product.ncols() < columns || self.factor.nrows() < PANEL {
            self.factor = Mat::zeros(PANEL, PANEL);
            self.product = Mat::zeros(PANEL, columns);
            self.turned = Mat::zeros(PANEL, columns);
        }
    }
}

/// Folds `block` (b × n) into `top` (p × n, upper triangular in its first p columns); n − p columns are right-hand
/// sides. Afterwards the first p columns of `block` hold Householder vectors and the rest what is left of the
/// right-hand sides, orthogonal to the columns.
pub(crate) fn fold(mut top: MatMut<'_, f64>, mut block: MatMut<'_, f64>, work: &mut Reflectors) {
    let (p, n) = (top.nrows(), top.ncols());
    if p == 0 || block.nrows() == 0 {
        return;
    }
    work.reserve(n);
    let Reflectors { factor, product, turned } = work;
    let mut start = 0;
    while start < p {
        let width = PANEL.min(p - start);
        let mut s = factor.as_mut().submatrix_mut(0, 0, width, width);
        s.fill(0.0);
        let mut rows = top.rb_mut().subrows_mut(start, width);
        panel(
            rows.rb_mut().subcols_mut(start, width),
            block.rb_mut().subcols_mut(start, width),
            s.rb_mut(),
            product.as_mut(),
            turned.as_mut(),
        );
        let (left, right) = block.rb_mut().split_at_col_mut(start + width);
        apply(
            left.rb().subcols(start, width),
            s.rb(),
            rows.subcols_mut(start + width, n - start - width),
            right,
            product.as_mut(),
            turned.as_mut(),
        );
        start += width;
    }
    for j in 0..p {
        if top[(j, j)] < 0.0 {
            for l in j..n {
                top[(j, l)] = -top[(j, l)];
            }
        }
    }
}

/// Recursive QR of a square triangle over a block of the same width.
fn panel(
    mut top: MatMut<'_, f64>,
    mut block: MatMut<'_, f64>,
    mut s: MatMut<'_, f64>,
    mut product: MatMut<'_, f64>,
    mut turned: MatMut<'_, f64>,
) {
    let width = top.ncols();
    if width <= LEAF.min(NEAR / block.nrows().max(1)).max(4) {
        return leaf(top, block, s);
    }
    let half = width / 2;
    let rest = width - half;
    let (s11, mut s12, _, s22) = s.rb_mut().split_at_mut(half, half);
    let (mut s11, mut s22) = (s11, s22);
    panel(
        top.rb_mut().submatrix_mut(0, 0, half, half),
        block.rb_mut().subcols_mut(0, half),
        s11.rb_mut(),
        product.rb_mut(),
        turned.rb_mut(),
    );
    let (left, mut right) = block.split_at_col_mut(half);
    apply(
        left.rb(),
        s11.rb(),
        top.rb_mut().submatrix_mut(0, half, half, rest),
        right.rb_mut(),
        product.rb_mut(),
        turned.rb_mut(),
    );
    panel(
        top.submatrix_mut(half, half, rest, rest),
        right.rb_mut(),
        s22.rb_mut(),
        product.rb_mut(),
        turned.rb_mut(),
    );
    // S12 = −S11 (V1ᵀ V2) S22; the identities of V1 and V2 do not overlap.
    let mut w = product.submatrix_mut(0, 0, half, rest);
    let mut t = turned.submatrix_mut(0, 0, half, rest);
    matmul(w.rb_mut(), Accum::Replace, left.rb().transpose(), right.rb(), 1.0, Par::Seq);
    matmul(t.rb_mut(), Accum::Replace, s11.rb(), w.rb(), 1.0, Par::Seq);
    matmul(s12.rb_mut(), Accum::Replace, t.rb(), s22.rb(), -1.0, Par::Seq);
}

/// [top; block] ← (I − V Sᵀ Vᵀ) [top; block].
fn apply(
    v: MatRef<'_, f64>,
    s: MatRef<'_, f64>,
    mut top: MatMut<'_, f64>,
    block: MatMut<'_, f64>,
    product: MatMut<'_, f64>,
    turned: MatMut<'_, f64>,
) {
    let (width, columns) = (top.nrows(), top.ncols());
    if columns == 0 {
        return;
    }
    let mut w = product.submatrix_mut(0, 0, width, columns);
    let mut t = turned.submatrix_mut(0, 0, width, columns);
    w.copy_from(top.rb());
    matmul(w.rb_mut(), Accum::Add, v.transpose(), block.rb(), 1.0, Par::Seq);
    matmul(t.rb_mut(), Accum::Replace, s.transpose(), w.rb(), 1.0, Par::Seq);
    for j in 0..columns {
        for i in 0..width {
            top[(i, j)] -= t[(i, j)];
        }
    }
    matmul(block, Accum::Add, v, t.rb(), -1.0, Par::Seq);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dense::norm;

    fn noise(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        }
    }

    /// The triangle has the Gram matrix of the rows that went in, and the rest of the right-hand side is what no column reaches.
    fn check(rows: usize, p: usize, blocks: usize) {
        let mut next = noise(7);
        let all = Mat::from_fn(rows, p + 1, |_, _| next());
        let mut top = Mat::zeros(p, p + 1);
        let mut work = Reflectors::default();
        let mut rest = 0.0;
        for b in 0..blocks {
            let (from, to) = (b * rows / blocks, (b + 1) * rows / blocks);
            let mut block = all.as_ref().subrows(from, to - from).to_owned();
            fold(top.as_mut(), block.as_mut(), &mut work);
            rest += block.col(p).squared_norm_l2();
        }
        let want = all.transpose() * &all;
        let have = top.transpose() * &top;
        for j in 0..=p {
            for i in 0..=j {
                let missing = if (i, j) == (p, p) { rest } else { 0.0 };
                assert!((have[(i, j)] + missing - want[(i, j)]).abs() < 1e-13 * rows as f64, "{i} {j}");
            }
        }
        for j in 0..p {
            assert!(top[(j, j)] >= 0.0);
            assert!((j + 1..p).all(|i| top[(i, j)].abs() < f64::MIN_POSITIVE));
        }
    }

    #[test]
    fn keeps_the_gram_matrix() {
        check(300, 1, 1);
        check(300, 7, 3);
        check(500, 130, 2);
        check(20, 33, 4);
    }

    #[test]
    fn tiny_and_huge_columns_come_through() {
        let mut next = noise(3);
        let scale = [1e-300, 1.0, 1e300];
        let mut block = Mat::from_fn(40, 4, |_, j| next() * scale.get(j).copied().unwrap_or(1.0));
        let copy = block.clone();
        let mut top = Mat::zeros(3, 4);
        fold(top.as_mut(), block.as_mut(), &mut Reflectors::default());
        let column = |j: usize| (0..40).map(|i| copy[(i, j)]).collect::<Vec<_>>();
        for (j, s) in scale.iter().enumerate() {
            let have = norm(&(0..3).map(|i| top[(i, j)]).collect::<Vec<_>>());
            assert!((have / norm(&column(j)) - 1.0).abs() < 1e-14, "{s}");
        }
    }
}
