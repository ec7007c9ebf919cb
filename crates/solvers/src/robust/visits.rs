//! The visits of a problem and the reweighting of their rows.

use super::contamination::{contaminated, normal};
use super::left_out::{LeftOut, left_out};
use super::{Loss, scale};
use crate::dense::norm;
use crate::{Fallback, LeastSquares, Solution, SolveError, Solver, Status};
use nalgebra::DVector;

/// Logarithm of the odds from which contamination counts as shown: 20 to 1, "strong evidence" (Kass and Raftery 1995).
const EVIDENCE: f64 = 2.995_732_273_553_991;

/// The visits of a problem.
pub(super) struct Visits<'a> {
    pub problem: &'a LeastSquares<'a>,
    pub groups: Vec<Vec<usize>>,
    weights: Vec<f64>,
    /// Below this a residual is round-off.
    floor: f64,
}

impl<'a> Visits<'a> {
    pub fn of(problem: &'a LeastSquares<'a>) -> Self {
        let weights: Vec<f64> = problem.weights.map_or_else(|| vec![1.0; problem.rows()], <[f64]>::to_vec);
        let groups = problem.groups_of_rows();
        let observed = norm(problem.residual(&DVector::zeros(problem.columns())).as_slice());
        let floor = 100.0 * f64::EPSILON * observed / (problem.rows().max(1) as f64).sqrt();
        Self { problem, groups, weights, floor }
    }

    /// Root mean square residual of each visit, with its number of rows that count.
    pub fn residuals(&self, x: &DVector<f64>) -> Vec<(f64, usize)> {
        let r = self.problem.residual(x);
        self.groups
            .iter()
            .map(|group| {
                let used: Vec<f64> =
                    group.iter().filter(|i| self.weights[**i] > 0.0).map(|i| r[*i]).collect();
                (norm(&used) / (used.len().max(1) as f64).sqrt(), used.len())
            })
            .collect()
    }

    /// The inner answer with the weights of each visit multiplied by `factors`.
    pub fn solve(&self, inner: &dyn Solver, factors: &[f64]) -> Result<Solution, SolveError> {
        let rows = self.per_row(factors);
        let weights: Vec<f64> = rows.iter().zip(&self.weights).map(|(f, w)| f * w).collect();
        let mut solution = inner.solve(&self.problem.with_weights(&weights))?;
        solution.info.residual_norm = norm(self.problem.residual(&solution.x).as_slice());
        solution.info.row_weights = Some(rows);
        Ok(solution)
    }

    fn per_row(&self, factors: &[f64]) -> Vec<f64> {
        let mut rows = vec![1.0; self.problem.rows()];
        for (group, factor) in self.groups.iter().zip(factors) {
            group.iter().for_each(|i| rows[*i] = *factor);
        }
        rows
    }

    fn noise(&self, residuals: &[(f64, usize)], rank: usize) -> f64 {
        scale::robust_scale(residuals, rank).max(self.floor).max(f64::MIN_POSITIVE)
    }

    pub fn iterate(
        &self,
        inner: &dyn Solver,
        loss: Loss,
        start: Solution,
        rounds: usize,
        tolerance: f64,
    ) -> Result<Solution, SolveError> {
        const FOLLOWING: usize = 20;
        let mut solution = start;
        let mut noise = 0.0;
        let mut settled = false;
        let mut before = self.problem.residual(&solution.x);
        for round in 1..=rounds {
            let residuals = self.residuals(&solution.x);
            if round <= FOLLOWING && !settled {
                let next = self.noise(&residuals, solution.rank);
                settled = (next - noise).abs() <= 1e-4 * next;
                noise = next;
            }
            let factors: Vec<f64> = residuals.iter().map(|(u, _)| loss.weight(u / noise)).collect();
            let next = self.solve(inner, &factors)?;
            if !next.status.is_success() {
                return Ok(next);
            }
            let after = self.problem.residual(&next.x);
            let moved = norm((&after - &before).as_slice());
            let size = norm(after.as_slice());
            solution = next;
            solution.info.iterations = round;
            solution.info.noise = Some(noise);
            before = after;
            if moved <= tolerance * size + self.floor {
                return Ok(solution);
            }
        }
        solution.status = Status::MaxIterations;
        Ok(solution)
    }

    /// The plain fit, unless the visits are contaminated and one of the robust fits predicts visits that it did not see with a higher density
    /// than the plain one does, under a contaminated normal distribution; of the robust fits the best by that measure.
    pub fn best(&self, mut plain: Solution, robust: Vec<Solution>) -> Result<Solution, SolveError> {
        let mut left = vec![self.left_out(&plain)?];
        for candidate in &robust {
            left.push(self.left_out(candidate)?);
        }
        let common: Vec<usize> =
            (0..self.groups.len()).filter(|&g| left.iter().all(|of_fit| of_fit[g].is_some())).collect();
        let of =
            |fit: &Vec<Option<LeftOut>>| -> Vec<LeftOut> { common.iter().filter_map(|&g| fit[g]).collect() };
        let of_plain = of(&left[0]);
        let (regular, mut best) = (normal(&of_plain), contaminated(&of_plain));
        let mut winner = None;
        for (candidate, left) in robust.into_iter().zip(&left[1..]) {
            let left = of(left);
            let score = contaminated(&left);
            let evident = score > regular.max(normal(&left)) + EVIDENCE;
            if candidate.status.is_success() && self.redundant(&candidate) && evident && score > best {
                (best, winner) = (score, Some(candidate));
            }
        }
        Ok(winner.unwrap_or_else(|| {
            plain.info.noise = Some(self.noise(&self.residuals(&plain.x), plain.rank));
            plain.info.row_weights = Some(vec![1.0; self.problem.rows()]);
            plain.info.fallback = plain.info.fallback.or(Some(Fallback::NoContamination));
            plain
        }))
    }

    /// Whether the weighted rows leave as many degrees of freedom as they determine unknowns: with fewer, some handful of visits agrees
    /// with itself by chance, and what the fit without one of them leaves depends on all others.
    fn redundant(&self, fit: &Solution) -> bool {
        let believed: f64 = match &fit.info.row_weights {
            Some(factors) => self.groups.iter().flatten().map(|&row| factors[row]).sum(),
            None => self.groups.iter().map(Vec::len).sum::<usize>() as f64,
        };
        believed >= 2.0 * fit.rank as f64
    }

    /// Each visit as the fit without it leaves it.
    fn left_out(&self, fit: &Solution) -> Result<Vec<Option<LeftOut>>, SolveError> {
        let factor = |group: &Vec<usize>| match (&fit.info.row_weights, group.first()) {
            (Some(weights), Some(&row)) => weights[row],
            _ => 1.0,
        };
        let factors: Vec<f64> = self.groups.iter().map(factor).collect();
        left_out(self.problem, &self.groups, &self.problem.residual(&fit.x), &factors)
    }
}
