//! Cholesky factor of a positive semidefinite matrix with the largest pivot first.
//!
//! Πᵀ G Π = L Lᵀ,  L_11² ≥ L_22² ≥ …, until what is left is round-off
//!
//! Source: Higham, *Accuracy and Stability of Numerical Algorithms*, §10.3; blocked as in LAPACK's dpstrf (Lucas 2004): the pivots of a
//! block are found column by column, everything beyond it is brought up to date once.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::reborrow::ReborrowMut;
use faer::{Accum, MatMut, Par};
use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};

const BLOCK: usize = 24;

/// The leading part of L, and where its columns come from.
pub(crate) struct PivotedCholesky {
    /// p × p; L in the lower triangle of the first `rank` columns.
    pub l: DMatrix<f64>,
    /// Column of G at each place.
    pub order: Vec<usize>,
    /// Squares of the pivots that were kept, as they were found.
    pub pivots: Vec<f64>,
    /// The largest that was not.
    pub rest: f64,
}

/// Factors the lower triangle of `g` as long as pivots are above `tolerance`.
pub(crate) fn pivoted_cholesky(g: DMatrix<f64>, tolerance: f64) -> PivotedCholesky {
    let p = g.nrows();
    let mut made =
        PivotedCholesky { l: g, order: (0..p).collect(), pivots: Vec::with_capacity(p), rest: 0.0 };
    let mut squares = vec![0.0; p];
    let mut from = 0;
    while from < p {
        let to = (from + BLOCK).min(p);
        squares[from..].fill(0.0);
        for k in from..to {
            let left = |i: usize| made.l[(i, i)] - squares[i];
            let best = (k..p).fold(k, |best, i| if left(i) > left(best) { i } else { best });
            let pivot = left(best);
            if pivot <= tolerance || pivot.is_nan() {
                made.rest = pivot.max(0.0);
                return made;
            }
            swap(&mut made.l, k, best);
            squares.swap(k, best);
            made.order.swap(k, best);
            made.pivots.push(pivot);
            Arch::new().dispatch(Column {
                l: made.l.as_mut_slice(),
                squares: &mut squares,
                p,
                from,
                k,
                root: pivot.sqrt(),
            });
        }
        if to < p {
            let (left, right) = made.l.as_mut_slice().split_at_mut(to * p);
            let done = faer::MatRef::from_column_major_slice_with_stride(
                &left[from * p + to..],
                p - to,
                to - from,
                p,
            );
            let mut rest =
                MatMut::from_column_major_slice_with_stride_mut(&mut right[to..], p - to, p - to, p);
            matmul(
                rest.rb_mut(),
                BlockStructure::TriangularLower,
                Accum::Add,
                done,
                BlockStructure::Rectangular,
                done.transpose(),
                BlockStructure::Rectangular,
                -1.0,
                Par::Seq,
            );
        }
        from = to;
    }
    made
}

/// Exchanges rows and columns i ≤ j of a symmetric matrix of which the lower triangle is given.
fn swap(l: &mut DMatrix<f64>, i: usize, j: usize) {
    if i == j {
        return;
    }
    let p = l.nrows();
    for k in 0..i {
        l.swap((i, k), (j, k));
    }
    for k in i + 1..j {
        l.swap((k, i), (j, k));
    }
    for k in j + 1..p {
        l.swap((k, i), (k, j));
    }
    l.swap((i, i), (j, j));
}

/// Column k of L, given the columns of its block in front of it.
struct Column<'a> {
    l: &'a mut [f64],
    squares: &'a mut [f64],
    p: usize,
    from: usize,
    k: usize,
    root: f64,
}

impl WithSimd for Column<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Column { l, squares, p, from, k, root } = self;
        let (before, own) = l.split_at_mut(k * p);
        let own = &mut own[k..p];
        for column in before[from * p..].chunks_exact(p) {
            let by = column[k];
            for (v, c) in own[1..].iter_mut().zip(&column[k + 1..]) {
                *v -= by * c;
            }
        }
        own[0] = root;
        let inverse = 1.0 / root;
        for (v, square) in own[1..].iter_mut().zip(&mut squares[k + 1..]) {
            *v *= inverse;
            *square += *v * *v;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rebuilds_the_matrix_and_finds_its_rank() {
        for (rows, p) in [(9, 4), (80, 61), (40, 61)] {
            let a = DMatrix::from_fn(rows, p, |i, j| ((i * 7 + j * j * 3 + i * j) as f64 * 0.37).sin());
            let g = a.tr_mul(&a);
            let found = pivoted_cholesky(g.clone(), 1e-11);
            assert_eq!(found.pivots.len(), rows.min(p), "{rows} {p}");
            assert!(found.pivots.windows(2).all(|w| w[0] >= w[1] * (1.0 - 1e-9)));
            let rank = found.pivots.len();
            let l = DMatrix::from_fn(p, rank, |i, j| if i >= j { found.l[(i, j)] } else { 0.0 });
            let back = &l * l.transpose();
            for i in 0..p {
                for j in 0..p {
                    let want = g[(found.order[i], found.order[j])];
                    assert!((back[(i, j)] - want).abs() < 1e-10, "{rows} {p}: {i} {j}");
                }
            }
        }
    }

    #[test]
    fn nothing_is_left_of_nothing() {
        let found = pivoted_cholesky(DMatrix::zeros(3, 3), 0.0);
        assert!(found.pivots.is_empty() && found.rest == 0.0);
        assert!(pivoted_cholesky(DMatrix::from_element(2, 2, f64::NAN), 0.0).pivots.is_empty());
    }
}
