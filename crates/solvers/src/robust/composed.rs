//! Any solver under a robust loss.

use super::visits::Visits;
use super::{Loss, Trimming};
use crate::{Fallback, LeastSquares, Need, Solution, SolveError, Solver};

/// Where the iterations start.
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
    /// Where the iterations start.
    pub start: Start,
    /// Largest number of iterations.
    pub max_iterations: usize,
    /// Ends when an iteration changes the residuals by less than this, relative to their norm.
    pub tolerance: f64,
    /// Whether the answer of the inner solver stands where the data gives no evidence of wrong visits; otherwise visits are weighted in any
    /// case, as textbooks do.
    pub only_where_contaminated: bool,
}

impl<S: Solver> Robust<S> {
    /// `inner` under a loss, from a start.
    pub fn new(inner: S, loss: Loss, start: Start) -> Self {
        let name = format!("{}({})", loss.name(), inner.name());
        // A penalty whose strength is chosen anew in each iteration moves by the resolution of that choice.
        let tolerance = if inner.supports(Need::Unpenalised) { 1e-10 } else { 1e-6 };
        Self { name, inner, loss, start, max_iterations: 200, tolerance, only_where_contaminated: true }
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
        if self.max_iterations == 0 {
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

    fn begin(
        &self,
        visits: &Visits<'_>,
        plain: &Solution,
    ) -> Result<(Solution, Option<Fallback>), SolveError> {
        match self.start {
            Start::Plain => Ok((plain.clone(), None)),
            Start::Huber => Ok((visits.iterate(&self.inner, Loss::huber(), plain.clone(), 30, 1e-4)?, None)),
            Start::Trimmed(trimming) => trimming.start(&self.inner, visits, plain.clone()),
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
        let plain = self.inner.solve(problem)?;
        if !plain.status.is_success() {
            return Ok(plain);
        }
        let (start, fallback) = self.begin(&visits, &plain)?;
        if !start.status.is_success() {
            return Ok(start);
        }
        let iterate =
            |start| visits.iterate(&self.inner, self.loss, start, self.max_iterations, self.tolerance);
        let mut robust = iterate(start)?;
        robust.info.fallback = robust.info.fallback.or(fallback);
        if !self.only_where_contaminated {
            return Ok(robust);
        }
        let mut candidates = vec![robust];
        if self.start != Start::Plain {
            // A loss that descends has several minima; that of the other start may be a worse one.
            candidates.insert(0, iterate(plain.clone())?);
        }
        visits.best(self.loss, plain, candidates)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{NormalEquations, PivotedQr, Ridge, Svd};
    use nalgebra::{DMatrix, DVector};

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
