//! The rounds of a fit: solve, move, look at the noise and the prior, until nothing moves.

mod whole;

pub(crate) use whole::from_factor;

use super::{Fit, FitOptions, NoiseSource, Warning, constraints, warnings};
use crate::freedom::Taken;
use crate::linearise::{collect, factorise, gram, misfit};
use crate::reduction::{Reduction, reduce_further};
use crate::{Freedom, IdentifyError, NoiseModel, Prior, PriorStrength, Residuals, estimate_noise};
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::{Dataset, Domain, ErrorModel, FittedModel, Noise, Visits};
use truepose_solvers::accumulator::Factor;
use truepose_solvers::{Bounds, ColumnScale, LeastSquares, Need, Solution, SolveError, Solver};

/// Everything that a fit has while it runs.
pub(super) struct State<'a> {
    model: &'a ErrorModel,
    data: &'a Dataset,
    visits: &'a Visits,
    solver: &'a dyn Solver,
    pub(super) options: FitOptions,
    observations: usize,
    noise: NoiseModel,
    pub(super) prior: Prior,
    pub(super) coefficients: Vec<f64>,
    /// Whether sums of products have held the digits of every factor so far.
    sums_hold: bool,
    /// What the unknowns leave to scatter, with the noise and the number of unknowns at which that was asked.
    freedom: Option<(NoiseModel, usize, Freedom)>,
}

/// How the rounds ended.
pub(super) struct Outcome {
    solution: Solution,
    rounds: usize,
    converged: bool,
    /// At the last coefficients, over the kept columns.
    factor: Factor,
    /// At the last coefficients.
    residuals: Residuals,
}

impl<'a> State<'a> {
    pub(super) fn new(
        model: &'a ErrorModel,
        data: &'a Dataset,
        visits: &'a Visits,
        solver: &'a dyn Solver,
        options: &FitOptions,
    ) -> Result<Self, IdentifyError> {
        options.validate()?;
        data.validate(model.chain())?;
        let observations: usize = (0..data.len()).map(|row| data.seen(row).count()).sum();
        if observations == 0 {
            return Err(IdentifyError::NothingMeasured { rows: data.len() });
        }
        let noise = match options.noise {
            NoiseSource::Estimate => NoiseModel::default(),
            NoiseSource::Fixed(noise) => noise,
        };
        let coefficients = vec![0.0; model.columns().len()];
        let (prior, options) = (Prior::none(), options.clone());
        Ok(State {
            model,
            data,
            visits,
            solver,
            options,
            observations,
            noise,
            prior,
            coefficients,
            sums_hold: true,
            freedom: None,
        })
    }

    /// Over all columns, or over these.
    pub(super) fn linearise(&self, columns: Option<&[usize]>) -> Result<Factor, IdentifyError> {
        factorise(self.model, self.data, self.visits, self.noise, &self.coefficients, columns)
    }

    /// Over the kept columns on the way, where half the digits do: from sums of products, as long as these hold them.
    fn passing(&mut self, kept: &[usize]) -> Result<Factor, IdentifyError> {
        /// Condition number of the columns, brought to length one.
        const MOST: f64 = 1e5;
        if self.sums_hold {
            let (model, data, visits, at) = (self.model, self.data, self.visits, &*self.coefficients);
            let sums = gram(model, data, visits, self.noise, at, Some(kept))?;
            if let Some(factor) = sums.finish_guarded(MOST)? {
                return Ok(factor);
            }
            self.sums_hold = false;
        }
        self.linearise(Some(kept))
    }

    /// Residuals, and the sum of their whitened squares.
    fn misfit(&self) -> Result<(Residuals, f64), IdentifyError> {
        misfit(self.model, self.data, self.visits, self.noise, &self.coefficients)
    }

    /// The factor with `r + A c` on its right-hand side instead of `r`; over the kept columns, β for c.
    fn absolute(&self, reduction: &Reduction, factor: &Factor) -> Factor {
        let mut absolute = factor.clone();
        let shift = &factor.r * DVector::from_vec(reduction.grouped(&self.coefficients));
        absolute.z.column_mut(0).zip_apply(&shift, |z, s| *z += s);
        absolute
    }

    /// Gauss–Newton rounds, with the noise estimated between them.
    pub(super) fn rounds(&mut self, reduction: &Reduction, first: Factor) -> Result<Outcome, IdentifyError> {
        /// Steps (in standard deviations, relative) below which nothing moves, and below which the noise is looked at.
        const STILL: f64 = 1e-8;
        const FIRST_LOOK: f64 = 0.1;
        const NEAR: f64 = 1e-4;
        const MOST_LOOKS: usize = 15;
        const FIRST_DAMPING: f64 = 1e-4;
        const WORSE: f64 = 1e-6;
        const MOST_FLAT: usize = 3;
        const MOST_UNGUARDED: usize = 20;
        // A penalty that only the solver knows, or weights that it changes, make no objective to hold steps against.
        let guarded = self.options.refine
            && self.solver.supports(Need::Unpenalised)
            && !self.solver.supports(Need::Outliers);
        let scales: Vec<f64> = reduction.kept.iter().map(|&c| self.model.columns()[c].scale).collect();
        let limit = match (self.options.refine, guarded) {
            (false, _) => 1,
            (true, true) => self.options.max_rounds,
            (true, false) => self.options.max_rounds.min(MOST_UNGUARDED),
        };
        // Noise and prior are looked at when steps have become short, the more often the less they still change.
        let mut near = FIRST_LOOK;
        let mut factor = first;
        let mut damping = 0.0;
        let (mut flat, mut looks) = (0, 0);
        let mut rounds = 0;
        loop {
            rounds += 1;
            let before = squares_of(&factor) + self.penalty(reduction);
            let (solution, target) = self.solve(reduction, &factor, &scales, damping)?;
            let mut moved = self.step(reduction, &factor, &target);
            let start = std::mem::replace(&mut self.coefficients, target);
            // Where the noise will be looked at, and where a step may well be taken back, residuals come first; elsewhere the new
            // factor says what is left.
            let last = rounds >= limit;
            let look = moved < near || last || flat + 1 >= MOST_FLAT;
            let (residuals, next, squares) = if look || damping > 0.0 {
                let (residuals, squares) = self.misfit()?;
                (Some(residuals), None, squares)
            } else {
                match self.passing(&reduction.kept) {
                    Ok(next) => {
                        let squares = squares_of(&next);
                        (None, Some(next), squares)
                    }
                    // Beyond all numbers, not merely too far.
                    Err(IdentifyError::Solve(SolveError::NotFinite { .. })) if guarded => {
                        (None, None, f64::INFINITY)
                    }
                    Err(error) => return Err(error),
                }
            };
            let squares = if squares.is_nan() { f64::INFINITY } else { squares };
            let after = squares + self.penalty(reduction);
            if guarded && moved > STILL && after > before * (1.0 + WORSE) && rounds < limit {
                // Too far for the linear picture: the same point again, with a shorter step. Weights follow the posture
                // from round to round only, so that the last steps may lose a trifle.
                self.coefficients = start;
                damping = (10.0 * damping).max(FIRST_DAMPING);
                continue;
            }
            damping = if damping > FIRST_DAMPING { 0.2 * damping } else { 0.0 };
            // In a flat valley steps stay long while nothing is gained any more: that is the end, too.
            flat = if guarded && before - after < self.options.flat * before { flat + 1 } else { 0 };
            if flat >= MOST_FLAT {
                moved = 0.0;
            }
            let Some(residuals) = residuals.filter(|_| look) else {
                factor = match next {
                    Some(next) => next,
                    None => self.passing(&reduction.kept)?,
                };
                continue;
            };
            near = NEAR.min(near);
            looks += 1;
            let mut settled = true;
            if self.options.noise == NoiseSource::Estimate {
                let freedom = self.freedom(reduction, &factor)?;
                let noise = estimate_noise(self.data, self.visits, &residuals, &freedom);
                settled &= alike(&self.noise, &noise, 2e-3);
                self.noise = noise;
            }
            factor =
                if last { self.linearise(Some(&reduction.kept))? } else { self.passing(&reduction.kept)? };
            if self.options.prior.asks_the_data() {
                settled &= self.look_at_prior(reduction, &self.absolute(reduction, &factor))?;
            }
            if settled || looks > MOST_LOOKS {
                settled = true;
                near = STILL;
            }
            if (settled && moved < STILL) || last {
                let converged = moved < STILL || !self.options.refine;
                let passed = self.sums_hold && !last;
                let factor = if passed { self.linearise(Some(&reduction.kept))? } else { factor };
                return Ok(Outcome { solution, rounds, converged, factor, residuals });
            }
        }
    }

    /// What the unknowns leave to scatter: as it was with nearly this noise, or anew.
    fn freedom(&mut self, reduction: &Reduction, factor: &Factor) -> Result<Freedom, IdentifyError> {
        /// Changes of the noise that move traces by a trifle.
        const NEARLY: f64 = 0.02;
        let rank = reduction.rank();
        if let Some((noise, of, freedom)) = &self.freedom
            && *of == rank
            && alike(noise, &self.noise, NEARLY)
        {
            return Ok(*freedom);
        }
        let (model, data, visits, coefficients) = (self.model, self.data, self.visits, &*self.coefficients);
        let taken = Taken { model, data, visits, noise: self.noise, coefficients, kept: &reduction.kept };
        let freedom = taken.left(factor, &self.prior)?;
        self.freedom = Some((self.noise, rank, freedom));
        Ok(freedom)
    }

    /// The prior as the data now has it; whether it stayed.
    fn look_at_prior(&mut self, reduction: &Reduction, factor: &Factor) -> Result<bool, IdentifyError> {
        let before = self.prior.clone();
        self.prior = self.prior.from_evidence(factor)?;
        if self.options.prior == PriorStrength::Kinds {
            let beta = reduction.grouped(&self.coefficients);
            if let Some(prior) = self.prior.by_kinds(self.model, reduction, factor, &beta) {
                self.prior = prior;
            }
        }
        let same = |a: f64, b: f64| (a / b).ln().abs() < 1e-2;
        let widths = self.prior.widths.iter().zip(&before.widths);
        Ok(same(self.prior.kappa, before.kappa) && widths.into_iter().all(|(a, b)| same(*a, *b)))
    }

    /// The reduction at the solution, when the data determines more there than at the nominal robot.
    pub(super) fn looked_at_again(
        &self,
        reduction: &Reduction,
        outcome: &Outcome,
    ) -> Result<Option<Reduction>, IdentifyError> {
        let (at, rule) = (&self.coefficients, self.options.rank);
        if reduction.dropped.is_empty() {
            return Ok(None);
        }
        let all = self.linearise(None)?;
        let more = reduce_further(self.model, self.data, &all, rule, at, reduction)?;
        if more.rank() <= reduction.rank() || !reduction.kept.iter().all(|c| more.kept.contains(c)) {
            return Ok(None);
        }
        // Directions that the data determines better than by their expected sizes.
        let determined = |kept: &[usize], factor: &Factor| -> Result<usize, IdentifyError> {
            let scales: Vec<f64> = kept.iter().map(|&c| self.model.columns()[c].scale).collect();
            let values = factor.singular_values(ColumnScale::Given(&scales))?;
            Ok(values.iter().filter(|d| **d >= 1.0).count())
        };
        if determined(&more.kept, &all.select(&more.kept))? <= determined(&reduction.kept, &outcome.factor)? {
            return Ok(None);
        }
        Ok(Some(more))
    }

    /// Shares the grouped errors out among the finer groups of another reduction, as the prior expects it: the same robot to first
    /// order, and no long way through the valley between them.
    pub(super) fn share_out(&mut self, coarse: &Reduction, fine: &Reduction) {
        let mut place = vec![usize::MAX; self.coefficients.len()];
        fine.kept.iter().enumerate().for_each(|(k, &column)| place[column] = k);
        let mut groups = DMatrix::zeros(coarse.rank(), fine.rank());
        for (row, group) in coarse.groups.iter().enumerate() {
            groups[(row, place[group.column])] = 1.0;
            let members = group.members.iter().filter(|(column, _)| place[*column] != usize::MAX);
            members.for_each(|&(column, weight)| groups[(row, place[column])] = weight);
        }
        if let Some(shared) = self.prior.shared_out(&groups, &coarse.grouped(&self.coefficients)) {
            self.coefficients = fine.expand(shared.as_slice(), self.coefficients.len());
        }
    }

    /// Squares of the prior, unless the solver has an objective of its own.
    fn penalty(&self, reduction: &Reduction) -> f64 {
        if self.solver.supports(Need::Outliers) {
            return 0.0;
        }
        self.prior.penalty(&reduction.grouped(&self.coefficients))
    }

    /// One solve for the grouped errors: the new coefficients.
    fn solve(
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
            let y = &rows.residual + &rows.a * DVector::from_column_slice(&self.coefficients);
            let (a, y) = self.with_prior(reduction.select(&rows.a), y);
            let mut groups = rows.visit;
            groups.extend((0..a.nrows() - groups.len()).map(|k| self.visits.len() + k));
            let problem = LeastSquares::new(&a, &y).with_scale(scales).with_row_groups(&groups);
            self.solver.solve(&constrained(problem))?
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
    fn step(&self, reduction: &Reduction, factor: &Factor, next: &[f64]) -> f64 {
        let next = DVector::from_vec(reduction.grouped(next));
        let change = &next - DVector::from_vec(reduction.grouped(&self.coefficients));
        (&factor.r * change).norm() / (1.0 + (&factor.r * next).norm())
    }

    pub(super) fn finish(self, reduction: Reduction, outcome: Outcome) -> Result<Fit, IdentifyError> {
        let columns = self.model.columns().len();
        let absolute = self.absolute(&reduction, &outcome.factor);
        let grouped = DVector::from_vec(reduction.grouped(&self.coefficients));
        let chi_square = absolute.residual_norm(0, &grouped).powi(2);
        let joined = self.prior.joined(&absolute, &vec![0.0; reduction.rank()])?;
        let inverse =
            joined.inverse_gram().unwrap_or_else(|| DMatrix::zeros(reduction.rank(), reduction.rank()));
        let covariance = spread_out(&inverse, &reduction.kept, columns);
        let mut fitted = FittedModel::new(self.model.clone(), self.coefficients.clone(), covariance)?;
        fitted.channels = self.data.schema.channels.clone();
        fitted.domain = Domain::of(self.data);
        let typical =
            median(self.data.position_sd.iter().flatten().copied().filter(|v| !v.is_nan()).collect());
        fitted.noise = Noise {
            position_sd: self.noise.position(typical).hypot(self.noise.visit_sd),
            orientation_sd: if self.data.orientation.iter().any(Option::is_some) {
                self.noise.orientation_sd
            } else {
                0.0
            },
        };
        let mut warnings = warnings::of(self.model, &reduction, self.observations);
        if !outcome.converged {
            warnings.push(Warning::NotConverged { rounds: outcome.rounds });
        }
        let mut fit = Fit {
            fitted,
            reduction,
            noise: self.noise,
            residuals: outcome.residuals,
            factor: absolute,
            prior: self.prior,
            rounds: outcome.rounds,
            converged: outcome.converged,
            observations: self.observations,
            chi_square,
            solution: outcome.solution,
            shapes: Vec::new(),
            scatter: self.freedom.map(|known| known.2),
            warnings,
        };
        let (model, at) = (self.model, fit.fitted.coefficients());
        let more = match (self.solver.supports(Need::Bounds), self.solver.supports(Need::ColumnGroups)) {
            (false, false) => constraints::violated(model, &fit.reduction, at, &fit.half_widths()),
            (_, true) => constraints::left_out(model, &fit.reduction, at),
            _ => Vec::new(),
        };
        fit.warnings.extend(more);
        Ok(fit)
    }
}

/// Whitened squares at the point of linearisation.
fn squares_of(factor: &Factor) -> f64 {
    factor.z.column(0).norm_squared() + factor.rss[0]
}

/// Whether two noises are the same but for this share.
fn alike(old: &NoiseModel, new: &NoiseModel, share: f64) -> bool {
    let close = |a: f64, b: f64| (a - b).abs() <= 0.5 * share * (a.abs() + b.abs()) + 1e-13;
    close(old.position_sd, new.position_sd)
        && close(old.visit_sd, new.visit_sd)
        && close(old.orientation_sd, new.orientation_sd)
}

/// A matrix over the kept columns, among all columns.
fn spread_out(inner: &DMatrix<f64>, kept: &[usize], columns: usize) -> DMatrix<f64> {
    let mut outer = DMatrix::zeros(columns, columns);
    for (i, &a) in kept.iter().enumerate() {
        for (j, &b) in kept.iter().enumerate() {
            outer[(a, b)] = inner[(i, j)];
        }
    }
    outer
}

fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
