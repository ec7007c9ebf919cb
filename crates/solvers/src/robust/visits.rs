//! The visits of a problem and the reweighting of their rows.

use super::contamination::{contaminated, normal};
use super::left_out::{LeftOut, Weighting, left_out};
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
        max_iterations: usize,
        tolerance: f64,
    ) -> Result<Solution, SolveError> {
        const RESCALED: usize = 20;
        let mut solution = start;
        let mut noise = 0.0;
        let mut scale_converged = false;
        let mut before = self.problem.residual(&solution.x);
        for iteration in 1..=max_iterations {
            let residuals = self.residuals(&solution.x);
            if iteration <= RESCALED && !scale_converged {
                let next = self.noise(&residuals, solution.rank);
                scale_converged = (next - noise).abs() <= 1e-4 * next;
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
            solution.info.iterations = iteration;
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
    /// than the plain one does, under a contaminated normal distribution; of the robust fits, the one nearest to the plain fit first, the best by that measure.
    pub fn best(
        &self,
        loss: Loss,
        mut plain: Solution,
        robust: Vec<Solution>,
    ) -> Result<Solution, SolveError> {
        let mut winner = None;
        if let Some(of_plain) = self.left_out(&plain, |_| Weighting::PLAIN)? {
            let mut least = f64::NEG_INFINITY;
            for (place, candidate) in robust.into_iter().enumerate() {
                // Another minimum than the one nearest to the plain fit has to show that as well.
                let least_gain = least.max(0.0) + if place > 0 { EVIDENCE } else { 0.0 };
                let noise = candidate.info.noise.unwrap_or(1.0);
                let weighting = |(u, n): (f64, usize)| Weighting {
                    factor: loss.weight(u / noise),
                    slope: loss.slope(u / noise) / (n.max(1) as f64 * noise * noise),
                };
                let Some(of_robust) = self.left_out(&candidate, weighting)? else { continue };
                let (mut before, mut after) = (Vec::new(), Vec::new());
                for (a, b) in of_plain.iter().zip(&of_robust) {
                    if let (Some(a), Some(b)) = (a, b) {
                        before.push(*a);
                        after.push(*b);
                    }
                }
                let score = contaminated(&after);
                let evident = score > normal(&before).max(normal(&after)) + EVIDENCE;
                let gain = score - contaminated(&before);
                if candidate.status.is_success() && self.redundant(&candidate) && evident && gain > least_gain
                {
                    (least, winner) = (gain, Some(candidate));
                }
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
        let effective: f64 = match &fit.info.row_weights {
            Some(factors) => self.groups.iter().flatten().map(|&row| factors[row]).sum(),
            None => self.groups.iter().map(Vec::len).sum::<usize>() as f64,
        };
        effective >= 2.0 * fit.rank as f64
    }

    /// Each visit as the fit without it leaves it; nothing where the fit is no minimum.
    fn left_out(
        &self,
        fit: &Solution,
        weighting: impl Fn((f64, usize)) -> Weighting,
    ) -> Result<Option<Vec<Option<LeftOut>>>, SolveError> {
        let weighting: Vec<Weighting> = self.residuals(&fit.x).into_iter().map(weighting).collect();
        left_out(self.problem, &self.groups, &self.problem.residual(&fit.x), &weighting)
    }
}
