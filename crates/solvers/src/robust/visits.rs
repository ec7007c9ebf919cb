//! The visits of a problem and the reweighting of their rows.

use super::{Loss, scale};
use crate::dense::norm;
use crate::{LeastSquares, Solution, SolveError, Solver, Status};
use nalgebra::DVector;

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
}
