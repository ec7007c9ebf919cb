//! Solutions from a Gram matrix where squared condition numbers leave enough digits, none elsewhere.

use super::Gram;
use crate::accumulator::Factor;
use crate::dense::{
    PivotedCholesky, cholesky_lower, pivoted_cholesky, solve_lower, solve_lower_many, solve_lower_transposed,
};
use crate::problem::check_len;
use crate::solver::status_of_rank;
use crate::{RankDecision, Solution, SolveError, SolverInfo};
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;

/// How many times larger than round-off, and than what is dropped, the square of the last pivot has to be.
const CLEAR: f64 = 100.0;

impl Gram {
    /// Basic solution of right-hand side `k` from a Cholesky factor with the largest pivot first, if the Gram matrix is fit to give one: columns
    /// that depend on others get zero. None where it is not, because no gap separates what is kept from round-off: then take a
    /// [`Triangular`](crate::accumulator::Triangular). `limit` is the highest condition number of the columns, brought to length one, that it
    /// is trusted with. What differs from other columns by less than 1e-7 of its length is not seen at all.
    pub fn solve_guarded(&self, k: usize, limit: f64) -> Result<Option<Solution>, SolveError> {
        check_len("right-hand sides", self.rhs, k + 1)?;
        let Some(clear) = self.clear(limit)? else { return Ok(None) };
        let moments = clear.moments(k);
        let reached: f64 = solve_lower(&clear.found.l, &moments).iter().map(|v| v * v).sum();
        let square = clear.whole[(self.columns + k, self.columns + k)];
        Ok(Some(clear.solution(clear.solve(&moments), (square - reached).max(0.0).sqrt())))
    }

    /// The columns that a Cholesky factor with the largest pivot first keeps; none where the guard refuses.
    pub(super) fn clear(&self, limit: f64) -> Result<Option<Clear<'_>>, SolveError> {
        let p = self.columns;
        let whole = self.flushed();
        let size: Vec<f64> =
            (0..p).map(|i| if whole[(i, i)] > 0.0 { 1.0 / whole[(i, i)].sqrt() } else { 1.0 }).collect();
        let mut scaled = DMatrix::zeros(p, p);
        for (j, (to, from)) in scaled
            .as_mut_slice()
            .chunks_exact_mut(p)
            .zip(whole.as_slice().chunks_exact(p + self.rhs))
            .enumerate()
        {
            let mut sum = 0.0;
            for ((to, from), size_of) in to[j..].iter_mut().zip(&from[j..]).zip(&size[j..]) {
                *to = from * size_of * size[j];
                sum += *to;
            }
            if !sum.is_finite() {
                return Err(SolveError::NotFinite { what: "the Gram matrix", row: j, column: j });
            }
        }
        let floor = p as f64 * f64::EPSILON;
        let found = pivoted_cholesky(scaled, floor);
        let last = found.pivots.last().copied().unwrap_or(1.0);
        if last * limit * limit < 1.0 || last < CLEAR * found.rest.max(floor) {
            return Ok(None);
        }
        Ok(Some(Clear { whole, size, found }))
    }

    /// `‖A R⁻¹‖²`, the trace of `R⁻ᵀ G R⁻¹`, with an upper triangle R of the same unknowns; none where R is singular or spans more than the
    /// squares can hold: its pivots, by the lengths of their columns, below 1e-5.
    ///
    /// # Errors
    /// When R has another size.
    pub fn norm_behind(&self, r: &DMatrix<f64>) -> Result<Option<f64>, SolveError> {
        const LEAST: f64 = 1e-5;
        let p = self.columns;
        check_len("columns of the triangle", p, r.ncols())?;
        check_len("rows of the triangle", p, r.nrows())?;
        let clear = |k: usize| r[(k, k)].abs() > LEAST * r.column(k).norm();
        if !(0..p).all(clear) {
            return Ok(None);
        }
        let whole = self.flushed();
        let mut turned = DMatrix::from_fn(p, p, |i, j| whole[(i.max(j), i.min(j))]);
        let lower = r.transpose();
        solve_lower_many(&lower, &mut turned);
        turned.transpose_mut();
        solve_lower_many(&lower, &mut turned);
        let trace = turned.trace();
        Ok(trace.is_finite().then(|| trace.max(0.0)))
    }

    /// The factor of all rows seen by Cholesky, where the columns, brought to length one, are no worse conditioned than `limit` in any
    /// direction that their pivots show; none otherwise. R is good to `limit² ε`.
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn finish_guarded(&self, limit: f64) -> Result<Option<Factor>, SolveError> {
        let (p, k) = (self.columns, self.rhs);
        let whole = self.flushed();
        if !whole.iter().fold(true, |all, v| all & v.is_finite()) {
            return Err(SolveError::NotFinite { what: "the Gram matrix", row: 0, column: 0 });
        }
        let size: Vec<f64> = (0..p).map(|i| whole[(i, i)].max(0.0).sqrt()).collect();
        if size.contains(&0.0) {
            return Ok(None);
        }
        let scaled =
            DMatrix::from_fn(p, p, |i, j| if i >= j { whole[(i, j)] / size[i] / size[j] } else { 0.0 });
        let Some(mut l) = cholesky_lower(scaled, p) else { return Ok(None) };
        if (0..p).any(|i| l[(i, i)] * limit < 1.0) {
            return Ok(None);
        }
        l.fill_upper_triangle(0.0, 1);
        let mut z = DMatrix::from_fn(p, k, |i, j| whole[(p + j, i)] / size[i]);
        solve_lower_many(&l, &mut z);
        let mut r = l.transpose();
        size.iter().enumerate().for_each(|(j, size)| r.column_mut(j).scale_mut(*size));
        let rss = (0..k).map(|j| (whole[(p + j, p + j)] - z.column(j).norm_squared()).max(0.0)).collect();
        Ok(Some(Factor { r, z, rss, rows: self.rows, resolution: (p.max(1) as f64 * f64::EPSILON).sqrt() }))
    }
}

/// What the guard keeps.
pub(super) struct Clear<'g> {
    /// Lower triangle of `[A | Y]ᵀ [A | Y]`.
    pub whole: Cow<'g, DMatrix<f64>>,
    /// What brings each column to length one.
    pub size: Vec<f64>,
    pub found: PivotedCholesky,
}

impl Clear<'_> {
    /// The columns that are kept, by falling pivots.
    pub fn kept(&self) -> &[usize] {
        &self.found.order[..self.found.pivots.len()]
    }

    /// The columns that depend on these.
    pub fn dropped(&self) -> &[usize] {
        &self.found.order[self.found.pivots.len()..]
    }

    /// The last pivot that is kept: a distance, of a column of length one, from all before it.
    pub fn last(&self) -> f64 {
        self.found.pivots.last().copied().unwrap_or(1.0).sqrt()
    }

    /// `A₁ᵀY_k` of the columns that are kept, brought to length one.
    pub fn moments(&self, k: usize) -> Vec<f64> {
        let p = self.size.len();
        self.kept().iter().map(|&c| self.whole[(p + k, c)] * self.size[c]).collect()
    }

    /// `(A₁ᵀA₁)⁻¹` times such moments, for columns as they are; zero for those that depend on others.
    pub fn solve(&self, moments: &[f64]) -> DVector<f64> {
        let inner = solve_lower(&self.found.l, moments);
        let inner = solve_lower_transposed(&self.found.l, inner.as_slice());
        let mut x = DVector::zeros(self.size.len());
        self.kept().iter().zip(inner.iter()).for_each(|(&c, v)| x[c] = v * self.size[c]);
        x
    }

    /// The solution that it is.
    pub fn solution(&self, x: DVector<f64>, residual_norm: f64) -> Solution {
        let (p, rank, rest) = (x.len(), self.kept().len(), self.found.rest.sqrt());
        let mut kept = self.kept().to_vec();
        kept.sort_unstable();
        let decision = RankDecision {
            rank,
            tolerance: (p as f64 * f64::EPSILON).sqrt(),
            last_kept: self.last(),
            first_dropped: rest,
            gap: if rest > 0.0 { self.last() / rest } else { f64::INFINITY },
            dropped: p - rank,
        };
        let info = SolverInfo {
            residual_norm,
            rank_decision: Some(decision),
            kept: Some(kept),
            ..SolverInfo::default()
        };
        Solution { x, rank, status: status_of_rank(rank, p), info }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RankRule;
    use crate::accumulator::{ColumnScale, Triangular};

    fn noise(i: usize, j: usize) -> f64 {
        ((i * i * 31 + j * 17 + i * j * 7) as f64 * 0.9).sin()
    }

    #[test]
    fn the_guard_gives_the_basic_solution_or_none() {
        let mut a = DMatrix::from_fn(60, 8, noise);
        let sum = a.column(0) + a.column(1) * 2.0;
        a.set_column(5, &sum);
        a.column_mut(3).scale_mut(1e6);
        let y = DMatrix::from_fn(60, 1, |i, _| noise(i, 40));
        let (mut gram, mut triangle) = (Gram::new(8, 1), Triangular::new(8, 1));
        gram.update(&a, &y).unwrap();
        triangle.update(&a, &y).unwrap();
        let found = gram.solve_guarded(0, 1e6).unwrap().unwrap();
        let want = triangle.finish().solve_pivoted(0, ColumnScale::Norms, RankRule::Default).unwrap();
        assert_eq!((found.rank, want.rank, found.info.kept.map(|kept| kept.len())), (7, 7, Some(7)));
        // The square of the condition number times round-off.
        assert!((&a * (&found.x - &want.x)).norm() < 1e-6);
        assert!((found.info.residual_norm - want.info.residual_norm).abs() < 1e-6);
        // A column that is another one but for 1e-4 of its length: trusted or not, as the caller says.
        let near = a.column(0) + DVector::from_fn(60, |i, _| 1e-4 * noise(i, 50));
        a.set_column(5, &near);
        let mut gram = Gram::new(8, 1);
        gram.update(&a, &y).unwrap();
        assert!(gram.solve_guarded(0, 1e3).unwrap().is_none());
        assert_eq!(gram.solve_guarded(0, 1e6).unwrap().unwrap().rank, 8);
        assert!(gram.solve_guarded(1, 1e6).is_err());
    }

    #[test]
    fn the_guarded_factor_is_that_of_the_rows_or_none() {
        let mut a = DMatrix::from_fn(60, 6, noise);
        a.column_mut(3).scale_mut(1e6);
        let y = DMatrix::from_fn(60, 2, |i, j| noise(i, 40 + j));
        let of = |a: &DMatrix<f64>| {
            let (mut gram, mut triangle) = (Gram::new(6, 2), Triangular::new(6, 2));
            gram.update(a, &y).unwrap();
            triangle.update(a, &y).unwrap();
            (gram, triangle.finish())
        };
        let (gram, want) = of(&a);
        let have = gram.finish_guarded(1e5).unwrap().unwrap();
        for j in 0..6 {
            // The same but for the signs of its rows.
            let column = |f: &Factor| f.r.column(j).abs();
            assert!((column(&have) - column(&want)).norm() < 1e-9 * column(&want).norm());
        }
        for k in 0..2 {
            assert!((have.z.column(k).norm() / want.z.column(k).norm() - 1.0).abs() < 1e-9);
            assert!((have.rss[k] - want.rss[k]).abs() < 1e-9 * want.rss[k]);
        }
        let near = a.column(0) + DVector::from_fn(60, |i, _| 1e-4 * noise(i, 50));
        a.set_column(5, &near);
        let (gram, want) = of(&a);
        assert!(gram.finish_guarded(1e3).unwrap().is_none());
        assert!(gram.finish_guarded(1e6).unwrap().is_some());
        // ‖A R⁻¹‖² of its own triangle is the number of columns, whichever way.
        assert!((gram.norm_behind(&want.r).unwrap().unwrap() - 6.0).abs() < 1e-6);
        let double = &want.r * 2.0;
        assert!((gram.norm_behind(&double).unwrap().unwrap() - 1.5).abs() < 1e-6);
        a.set_column(5, &(a.column(0) * 2.0));
        let (gram, want) = of(&a);
        assert!(gram.finish_guarded(1e6).unwrap().is_none());
        assert!(gram.norm_behind(&want.r).unwrap().is_none());
        a[(0, 0)] = f64::NAN;
        assert!(Gram::new(6, 2).update(&a, &y).is_err());
    }
}
