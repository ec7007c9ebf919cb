//! One round's problem, and its solution.

use super::state::State;
use crate::IdentifyError;
use crate::fit::constraints;
use crate::linearise::{Rows, collect};
use crate::reduction::Reduction;
use nalgebra::{DMatrix, DVector};
use truepose_solvers::accumulator::Factor;
use truepose_solvers::{Bounds, LeastSquares, Need, Solution};

impl State<'_> {
    /// One solve for the grouped errors: the new coefficients.
    pub(super) fn solve(
        &self,
        reduction: &Reduction,
        factor: &Factor,
        scales: &[f64],
        damping: f64,
    ) -> Result<(Solution, Vec<f64>), IdentifyError> {
        let columns = self.model.columns().len();
        let bounds = constraints::bounds(self.model, reduction);
        let effects = constraints::effects(self.model, reduction);
        let constrained = |problem| self.constrained(problem, &bounds, &effects);
        // Plain least squares is the same on the triangle; whoever weighs rows or validates on them has to see them.
        let plain = self.solver.supports(Need::Unpenalised) && !self.solver.supports(Need::Outliers);
        let solution = if !plain {
            let rows = collect(self.model, self.data, self.visits, self.noise, &self.coefficients)?;
            self.solve_rows(reduction, &rows, scales)?
        } else {
            let small = self.absolute(reduction, factor);
            let y = small.z.column(0).into_owned();
            let (a, y) = self.with_prior(small.r, y);
            let (a, y) = self.damped(a, y, &reduction.grouped(&self.coefficients), damping);
            self.solver.solve(&constrained(LeastSquares::new(&a, &y).with_scale(scales)))?
        };
        if !solution.x.iter().all(|v| v.is_finite()) {
            return Err(IdentifyError::NoAnswer {
                solver: self.solver.name().into(),
                status: format!("{:?}", solution.status),
            });
        }
        let next = reduction.expand(solution.x.as_slice(), columns);
        Ok((solution, next))
    }

    /// The solver's answer to whitened rows, with those of the prior below them.
    pub(super) fn solve_rows(
        &self,
        reduction: &Reduction,
        rows: &Rows,
        scales: &[f64],
    ) -> Result<Solution, IdentifyError> {
        let bounds = constraints::bounds(self.model, reduction);
        let effects = constraints::effects(self.model, reduction);
        let y = &rows.residual + &rows.a * DVector::from_column_slice(&self.coefficients);
        let (a, y) = self.with_prior(reduction.select(&rows.a), y);
        let mut groups = rows.visit.clone();
        let more = a.nrows() - groups.len();
        groups.extend((0..more).map(|k| self.visits.len() + k));
        let problem =
            LeastSquares::new(&a, &y).with_scale(scales).with_row_groups(&groups).with_prior_rows(more);
        Ok(self.solver.solve(&self.constrained(problem, &bounds, &effects))?)
    }

    /// The problem with bounds, and with the effect of each column, for solvers that hold or ask for them.
    fn constrained<'p>(
        &self,
        problem: LeastSquares<'p>,
        bounds: &'p Bounds,
        effects: &'p [usize],
    ) -> LeastSquares<'p> {
        let problem = match bounds.any() && self.solver.supports(Need::Bounds) {
            true => problem.with_bounds(bounds),
            false => problem,
        };
        match self.solver.supports(Need::ColumnGroups) {
            true => problem.with_column_groups(effects),
            false => problem,
        }
    }

    /// The problem with the rows of the prior, `W β = 0`.
    fn with_prior(&self, a: DMatrix<f64>, y: DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
        let Some(prior) = self.prior.rows() else { return (a, y) };
        let rows = a.nrows();
        let more = prior.nrows();
        let mut a = a.resize_vertically(rows + more, 0.0);
        a.rows_mut(rows, more).copy_from(&prior);
        (a, y.resize_vertically(rows + more, 0.0))
    }

    /// The problem with rows that hold the unknowns where they are, `√λ W₁ (β − β_now) = 0` (Levenberg, Marquardt),
    /// measured in expected sizes.
    fn damped(
        &self,
        a: DMatrix<f64>,
        y: DVector<f64>,
        now: &[f64],
        damping: f64,
    ) -> (DMatrix<f64>, DVector<f64>) {
        if damping <= 0.0 {
            return (a, y);
        }
        let hold = self.prior.unit_rows() * damping.sqrt();
        let (rows, more) = (a.nrows(), hold.nrows());
        let mut a = a.resize_vertically(rows + more, 0.0);
        let mut y = y.resize_vertically(rows + more, 0.0);
        y.rows_mut(rows, more).copy_from(&(&hold * DVector::from_column_slice(now)));
        a.rows_mut(rows, more).copy_from(&hold);
        (a, y)
    }

    /// How far a step goes, in standard deviations of the data or relative to its size, whichever is finer.
    pub(super) fn step(&self, reduction: &Reduction, factor: &Factor, next: &[f64]) -> f64 {
        let next = DVector::from_vec(reduction.grouped(next));
        let change = &next - DVector::from_vec(reduction.grouped(&self.coefficients));
        (&factor.r * change).norm() / (1.0 + (&factor.r * next).norm())
    }
}
