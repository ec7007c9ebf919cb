//! Robustness as composition: any solver, asked again and again with the weights of suspicious visits lowered.
//!
//! u_g = ‖W^{1/2} (A x − y)‖_g / √n_g,  w_g = ψ(u_g / σ̂) / (u_g / σ̂),  solve with W · w, repeat
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | u_g | root mean square residual of a visit (group of rows) | visits | 1 when whitened |
//! | n_g | rows of the visit that have a weight | visits | 1 |
//! | σ̂ | robust scale of u | 1 | that of u |
//! | w_g | factor on the weights of that visit's rows | visits | 1 |
//!
//! Source: Huber and Ronchetti, *Robust Statistics* (2009), ch. 7; Maronna, Martin, Yohai and Salibián-Barrera, *Robust
//! Statistics* (2019), §5. The scale follows the residuals for the first rounds and is then held, so that the rounds
//! converge. Whole visits are weighted because a bad visit (a bumped target, a wrong pose) spoils all of its rows.

mod loss;
mod scale;
mod trimmed;

pub use loss::Loss;
pub use trimmed::Trimming;

use crate::dense::norm;
use crate::{Fallback, LeastSquares, Need, Solution, SolveError, Solver, Status};
use nalgebra::DVector;

/// Where the rounds begin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum Start {
    /// At the plain answer of the inner solver.
    #[default]
    Plain,
    /// At the answer of a Huber fit.
    Huber,
    /// At the fit of the visits that agree best with each other.
    Trimmed(Trimming),
}

/// A solver made robust.
#[derive(Debug, Clone)]
pub struct Robust<S> {
    name: String,
    inner: S,
    /// What a large residual costs.
    pub loss: Loss,
    /// Where the rounds begin.
    pub start: Start,
    /// Largest number of rounds.
    pub rounds: usize,
    /// Ends when a round changes the residuals by less than this, relative to their norm.
    pub tolerance: f64,
}

impl<S: Solver> Robust<S> {
    /// `inner` under a loss, begun where it should be.
    pub fn new(inner: S, loss: Loss, start: Start) -> Self {
        let name = format!("{}({})", loss.name(), inner.name());
        // A penalty whose strength is chosen anew in each round moves by the resolution of that choice.
        let tolerance = if inner.supports(Need::Unpenalised) { 1e-10 } else { 1e-6 };
        Self { name, inner, loss, start, rounds: 200, tolerance }
    }

    /// Huber's loss with k = 1.345: keeps every visit, limits its pull.
    pub fn huber(inner: S) -> Self {
        Self::new(inner, Loss::huber(), Start::Plain)
    }

    /// Tukey's biweight with c = 4.685, from a trimmed start: leaves wrong visits out altogether.
    pub fn tukey(inner: S) -> Self {
        Self::new(inner, Loss::tukey(), Start::Trimmed(Trimming::default()))
    }

    fn validate(&self) -> Result<(), SolveError> {
        let bad = |option, value, expected| Err(SolveError::BadOption { option, value, expected });
        if self.rounds == 0 {
            return bad("rounds", 0.0, "at least 1");
        }
        if self.tolerance <= 0.0 || self.tolerance.is_nan() {
            return bad("tolerance", self.tolerance, "a number > 0");
        }
        if let Start::Trimmed(trimming) = self.start {
            trimming.validate()?;
        }
        self.loss.validate()
    }

    fn begin(&self, visits: &Visits<'_>) -> Result<(Solution, Option<Fallback>), SolveError> {
        match self.start {
            Start::Plain => Ok((self.inner.solve(visits.problem)?, None)),
            Start::Huber => {
                let first = self.inner.solve(visits.problem)?;
                Ok((visits.iterate(&self.inner, Loss::huber(), first, 30, 1e-4)?, None))
            }
            Start::Trimmed(trimming) => trimming.start(&self.inner, visits),
        }
    }
}

impl<S: Solver> Solver for Robust<S> {
    fn name(&self) -> &str {
        &self.name
    }

    fn supports(&self, need: Need) -> bool {
        match need {
            Need::Outliers => true,
            other => self.inner.supports(other),
        }
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        self.validate()?;
        problem.admit(self)?;
        if !self.inner.supports(Need::Weights) {
            return Err(SolveError::Unsupported {
                solver: self.inner.name().to_owned(),
                need: Need::Weights,
            });
        }
        let visits = Visits::of(problem);
        let (start, fallback) = self.begin(&visits)?;
        if !start.status.is_success() {
            return Ok(start);
        }
        let mut solution = visits.iterate(&self.inner, self.loss, start, self.rounds, self.tolerance)?;
        solution.info.fallback = solution.info.fallback.or(fallback);
        Ok(solution)
    }
}

/// The visits of a problem.
struct Visits<'a> {
    problem: &'a LeastSquares<'a>,
    groups: Vec<Vec<usize>>,
    weights: Vec<f64>,
    /// Below this a residual is round-off.
    floor: f64,
}

impl<'a> Visits<'a> {
    fn of(problem: &'a LeastSquares<'a>) -> Self {
        let weights: Vec<f64> = problem.weights.map_or_else(|| vec![1.0; problem.rows()], <[f64]>::to_vec);
        let groups = problem.groups_of_rows();
        let observed = norm(problem.residual(&DVector::zeros(problem.columns())).as_slice());
        let floor = 100.0 * f64::EPSILON * observed / (problem.rows().max(1) as f64).sqrt();
        Self { problem, groups, weights, floor }
    }

    /// Root mean square residual of each visit, with its number of rows that count.
    fn residuals(&self, x: &DVector<f64>) -> Vec<(f64, usize)> {
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
    fn solve(&self, inner: &dyn Solver, factors: &[f64]) -> Result<Solution, SolveError> {
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

    fn iterate(
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{NormalEquations, PivotedQr, Ridge, Svd};
    use nalgebra::DMatrix;

    /// Thirty measured rows of a direction that nothing but the prior's row holds, and one wrong row.
    #[test]
    fn a_prior_keeps_its_weight() {
        let rows = 31;
        let a = DMatrix::from_fn(rows, 2, |i, j| match (i, j) {
            (30, 0) => 0.0,
            (30, _) => 5.0,
            (_, 0) => 1.0,
            _ => 1e-3 * ((i * 7) as f64).sin(),
        });
        let y = DVector::from_fn(rows, |i, _| match i {
            30 => 0.0,
            3 => 40.0,
            _ => 1.0 + 0.1 * ((i * i) as f64 * 0.77).sin(),
        });
        // Unlike anything that was measured, and far from what the rows would like: as an outlier it would be thrown out.
        let y = DVector::from_fn(rows, |i, _| if i == 30 { 25.0 } else { y[i] });
        for solver in [Robust::huber(PivotedQr::default()), Robust::tukey(PivotedQr::default())] {
            let found = solver.solve(&LeastSquares::new(&a, &y).with_prior_rows(1)).unwrap();
            let weights = found.info.row_weights.unwrap();
            assert!((weights[30] - 1.0).abs() < 1e-12 && weights[3] < 0.1, "{weights:?}");
            assert!((found.x[1] - 5.0).abs() < 0.1 && (found.x[0] - 1.0).abs() < 0.1, "{}", found.x);
        }
    }

    #[test]
    fn every_composition_passes_the_kit() {
        crate::testkit::check_solver(&Robust::huber(PivotedQr::default()));
        crate::testkit::check_solver(&Robust::tukey(Svd::default()));
        crate::testkit::check_solver(&Robust::new(NormalEquations::default(), Loss::tukey(), Start::Huber));
        crate::testkit::check_solver(&Robust::tukey(Ridge::default()));
    }
}
