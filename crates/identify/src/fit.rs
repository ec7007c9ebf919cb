//! The fit: reduce, solve, re-linearise at the exact robot, until nothing moves (Eq. 18–19, and beyond).
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | c | coefficients of the model | p | each its own |
//! | β | grouped errors, c = B β | r | as the kept column |
//! | A | whitened design matrix at c | m × p | 1 per unit |
//! | r | whitened y − y(c) | m | 1 |
//!
//! | W | prior, see [`crate::Prior`] | r × r | 1 per unit |
//!
//! Each round solves `min ‖A B β − (r + A c)‖² + ‖W β‖²` for the grouped errors themselves, not for their change: so a
//! solver with bounds means the errors. The second term leaves alone what the data determines, and keeps directions
//! that it hardly excites from running away: the posterior standard deviation of a direction is never above its
//! prior one (statistics 6.1). A step that makes things worse is halved. The first round alone, without a
//! prior, is the paper's linear fit.

use crate::linearise::{collect, factorise};
use crate::reduction::{Reduction, reduce};
use crate::{IdentifyError, NoiseModel, Prior, PriorStrength, Residuals, Spread, estimate_noise};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};
use truepose_errormodel::{Dataset, Domain, ErrorModel, FittedModel, Noise, Visits};
use truepose_solvers::accumulator::Factor;
use truepose_solvers::{LeastSquares, Need, RankRule, Solution, Solver};

/// How to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitOptions {
    /// Re-linearise until nothing moves; otherwise the paper's single linear step.
    pub refine: bool,
    /// Rounds at most.
    pub max_rounds: usize,
    /// How ranks are decided.
    pub rank: RankRule,
    /// How strongly coefficients are held to their expected sizes.
    pub prior: PriorStrength,
    /// Where standard deviations come from.
    pub noise: NoiseSource,
}

/// Where the standard deviations of the rows come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoiseSource {
    /// From the residuals, on top of what the instrument states.
    Estimate,
    /// Given.
    Fixed(NoiseModel),
}

impl Default for FitOptions {
    fn default() -> Self {
        FitOptions {
            refine: true,
            max_rounds: 500,
            rank: RankRule::Default,
            prior: PriorStrength::Evidence,
            noise: NoiseSource::Estimate,
        }
    }
}

impl FitOptions {
    /// Checks the ranges.
    ///
    /// # Errors
    /// Names the option that is out of its range.
    pub fn validate(&self) -> Result<(), IdentifyError> {
        self.rank.validate()?;
        if let PriorStrength::Fixed(kappa) = self.prior
            && !(kappa.is_finite() && kappa > 0.0)
        {
            return Err(IdentifyError::Option { option: "prior", value: kappa, expected: "above 0" });
        }
        if self.max_rounds == 0 {
            return Err(IdentifyError::Option { option: "max_rounds", value: 0.0, expected: "at least 1" });
        }
        Ok(())
    }
}

/// A fitted model and everything that is known about the fit.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The model with its coefficients and their covariance.
    pub fitted: FittedModel,
    /// What was reduced away, and what each kept coefficient stands for.
    pub reduction: Reduction,
    /// Standard deviations, given or estimated.
    pub noise: NoiseModel,
    /// Residuals on the data of the fit.
    pub residuals: Residuals,
    /// Whitened triangular factor of `[A B | r + A c]` at the solution: the small problem that says it all.
    pub factor: Factor,
    /// The prior on the grouped errors, with the κ that was used.
    pub prior: Prior,
    /// Rounds that were taken.
    pub rounds: usize,
    /// Whether the last round moved nothing any more.
    pub converged: bool,
    /// Measured numbers m.
    pub observations: usize,
    /// Sum of whitened squares at the solution.
    pub chi_square: f64,
    /// What the solver said last.
    pub solution: Solution,
    /// Things that a user should know.
    pub warnings: Vec<Warning>,
}

/// Something that a user should know about a fit.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// The singular values show no clear gap where the rank was cut.
    UnclearRank {
        /// Of all postures within the limits, or of this data.
        structural: bool,
        /// Smallest value kept over largest value dropped.
        gap: f64,
    },
    /// Fewer measured numbers than unknowns: some were set to zero.
    FewerRowsThanUnknowns {
        /// Measured numbers.
        observations: usize,
        /// Unknowns before the reduction.
        unknowns: usize,
    },
    /// The rounds ended before nothing moved any more.
    NotConverged {
        /// How many were taken.
        rounds: usize,
    },
    /// As many unknowns as numbers: the residual says nothing about the accuracy.
    NoRedundancy,
}

impl Fit {
    /// Degrees of freedom m − r, at least one.
    pub fn degrees_of_freedom(&self) -> usize {
        self.observations.saturating_sub(self.reduction.rank()).max(1)
    }

    /// Half width of the 95 % interval of each coefficient of the model, in its unit; zero for dropped ones.
    pub fn half_widths(&self) -> Vec<f64> {
        let quantile = student_quantile(0.975, self.degrees_of_freedom());
        let covariance = self.fitted.covariance();
        (0..covariance.nrows()).map(|k| quantile * covariance[(k, k)].max(0.0).sqrt()).collect()
    }

    /// Statistics of the 3-D position error on the data of the fit, m.
    pub fn positions(&self) -> Spread {
        self.residuals.positions()
    }
}

/// Quantile of Student's t.
pub fn student_quantile(probability: f64, freedom: usize) -> f64 {
    StudentsT::new(0.0, 1.0, freedom as f64).map_or(1.96, |t| t.inverse_cdf(probability))
}

/// Fits a model to data.
///
/// # Errors
/// When the data does not fit the model, nothing was measured, or the solver refuses.
pub fn fit(
    model: &ErrorModel,
    data: &Dataset,
    solver: &dyn Solver,
    options: &FitOptions,
) -> Result<Fit, IdentifyError> {
    let visits = Visits::of(data);
    let mut state = State::new(model, data, &visits, solver, options)?;
    let factor = state.linearise()?;
    let reduction = reduce(model, data, &factor, options.rank)?;
    state.prior = Prior::new(model, &reduction, options.prior);
    let outcome = state.rounds(&reduction, factor)?;
    state.finish(reduction, outcome)
}

/// Fits with a reduction and a prior that are already known; nothing about the structure is decided again.
///
/// # Errors
/// As [`fit`].
pub fn refit(
    model: &ErrorModel,
    data: &Dataset,
    solver: &dyn Solver,
    options: &FitOptions,
    reduction: &Reduction,
    prior: &Prior,
) -> Result<Fit, IdentifyError> {
    let visits = Visits::of(data);
    let mut state = State::new(model, data, &visits, solver, options)?;
    state.prior = prior.clone();
    state.options.prior = PriorStrength::Fixed(prior.kappa);
    let factor = state.linearise()?;
    let outcome = state.rounds(reduction, factor)?;
    state.finish(reduction.clone(), outcome)
}

struct State<'a> {
    model: &'a ErrorModel,
    data: &'a Dataset,
    visits: &'a Visits,
    solver: &'a dyn Solver,
    options: FitOptions,
    observations: usize,
    noise: NoiseModel,
    prior: Prior,
    coefficients: Vec<f64>,
}

struct Outcome {
    solution: Solution,
    rounds: usize,
    converged: bool,
    /// At the last coefficients.
    factor: Factor,
}

impl<'a> State<'a> {
    fn new(
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
        let prior = Prior::new(model, &Reduction::none(coefficients.len()), PriorStrength::None);
        let options = options.clone();
        Ok(State { model, data, visits, solver, options, observations, noise, prior, coefficients })
    }

    fn linearise(&self) -> Result<Factor, IdentifyError> {
        factorise(self.model, self.data, self.visits, self.noise, &self.coefficients)
    }

    /// The factor with `r + A c` on its right-hand side instead of `r`.
    fn absolute(&self, factor: &Factor, at: &[f64]) -> Factor {
        let mut absolute = factor.clone();
        let shift = &factor.r * DVector::from_column_slice(at);
        absolute.z.column_mut(0).zip_apply(&shift, |z, s| *z += s);
        absolute
    }

    /// Gauss–Newton rounds, with the noise estimated between them.
    fn rounds(&mut self, reduction: &Reduction, first: Factor) -> Result<Outcome, IdentifyError> {
        /// Steps (in standard deviations, relative) below which nothing moves, and below which the noise is looked at.
        const STILL: f64 = 1e-8;
        const FIRST_LOOK: f64 = 0.1;
        const NEAR: f64 = 1e-4;
        const MOST_LOOKS: usize = 15;
        const FIRST_DAMPING: f64 = 1e-4;
        // A penalty that only the solver knows, or weights that it changes, make no objective to hold steps against.
        let guarded = self.options.refine
            && self.solver.supports(Need::Unpenalised)
            && !self.solver.supports(Need::Outliers);
        let scales: Vec<f64> = reduction.kept.iter().map(|&c| self.model.columns()[c].scale).collect();
        let limit = if self.options.refine { self.options.max_rounds } else { 1 };
        // Noise and prior are looked at when steps have become short, the more often the less they still change.
        let mut near = FIRST_LOOK;
        let mut factor = first;
        let mut damping = 0.0;
        let (mut flat, mut looks) = (0, 0);
        let mut rounds = 0;
        loop {
            rounds += 1;
            let before = self.objective(reduction, &factor, &self.coefficients);
            let (solution, target) = self.solve(reduction, &factor, &scales, damping)?;
            let mut moved = self.step(&factor, &target);
            let start = std::mem::replace(&mut self.coefficients, target);
            let next = self.linearise()?;
            let after = self.objective(reduction, &next, &self.coefficients);
            if guarded && moved > STILL && after > before * (1.0 + 1e-12) && rounds < limit {
                // Too far for the linear picture: the same point again, with a shorter step.
                self.coefficients = start;
                damping = (10.0 * damping).max(FIRST_DAMPING);
                continue;
            }
            damping = if damping > FIRST_DAMPING { 0.2 * damping } else { 0.0 };
            factor = next;
            // In a flat valley steps stay long while nothing is gained any more: that is the end, too.
            flat = if guarded && before - after < 1e-10 * before { flat + 1 } else { 0 };
            if flat >= 3 {
                moved = 0.0;
            }
            let last = rounds >= limit;
            if moved < near || last {
                near = NEAR.min(near);
                looks += 1;
                let mut settled = true;
                if self.options.noise == NoiseSource::Estimate {
                    let noise = self.estimate(reduction)?;
                    settled &= alike(&self.noise, &noise);
                    self.noise = noise;
                    factor = self.linearise()?;
                }
                if self.options.prior == PriorStrength::Evidence {
                    let inner = self.absolute(&factor, &self.coefficients).select(&reduction.kept);
                    let prior = self.prior.from_evidence(&inner)?;
                    settled &= (prior.kappa / self.prior.kappa).ln().abs() < 1e-2;
                    self.prior = prior;
                }
                if settled || looks > MOST_LOOKS {
                    settled = true;
                    near = STILL;
                }
                if (settled && moved < STILL) || last {
                    let converged = moved < STILL || !self.options.refine;
                    return Ok(Outcome { solution, rounds, converged, factor });
                }
            }
        }
    }

    /// Whitened squares at the point of linearisation, prior included.
    fn objective(&self, reduction: &Reduction, factor: &Factor, at: &[f64]) -> f64 {
        let prior = if self.solver.supports(Need::Outliers) {
            0.0
        } else {
            self.prior.penalty(&reduction.grouped(at))
        };
        factor.z.column(0).norm_squared() + factor.rss[0] + prior
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
        let solution = if self.solver.supports(Need::Outliers) {
            let rows = collect(self.model, self.data, self.visits, self.noise, &self.coefficients)?;
            let y = &rows.residual + &rows.a * DVector::from_column_slice(&self.coefficients);
            let (a, y) = self.with_prior(reduction.select(&rows.a), y);
            let mut groups = rows.visit;
            groups.extend((0..a.nrows() - groups.len()).map(|k| self.visits.len() + k));
            let problem = LeastSquares::new(&a, &y).with_scale(scales).with_row_groups(&groups);
            self.solver.solve(&problem)?
        } else {
            let small = self.absolute(factor, &self.coefficients);
            let (a, y) = self.with_prior(reduction.select(&small.r), small.z.column(0).into_owned());
            let (a, y) = self.damped(a, y, &reduction.grouped(&self.coefficients), damping);
            self.solver.solve(&LeastSquares::new(&a, &y).with_scale(scales))?
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
    fn step(&self, factor: &Factor, next: &[f64]) -> f64 {
        let change =
            DVector::from_iterator(next.len(), next.iter().zip(&self.coefficients).map(|(a, b)| a - b));
        let moved = (&factor.r * change).norm();
        let size = (&factor.r * DVector::from_column_slice(next)).norm();
        moved / (1.0 + size)
    }

    fn estimate(&self, reduction: &Reduction) -> Result<NoiseModel, IdentifyError> {
        let residuals = self.residuals()?;
        let used = reduction.rank() as f64 / self.observations as f64;
        Ok(estimate_noise(self.data, self.visits, &residuals, (1.0 - used).max(0.02)))
    }

    fn residuals(&self) -> Result<Residuals, IdentifyError> {
        let columns = self.model.columns().len();
        let plain = FittedModel::new(
            self.model.clone(),
            self.coefficients.clone(),
            DMatrix::zeros(columns, columns),
        )?;
        Residuals::of(&plain, self.data)
    }

    fn finish(self, reduction: Reduction, outcome: Outcome) -> Result<Fit, IdentifyError> {
        let columns = self.model.columns().len();
        let absolute = self.absolute(&outcome.factor, &self.coefficients).select(&reduction.kept);
        let grouped =
            DVector::from_iterator(reduction.rank(), reduction.kept.iter().map(|&c| self.coefficients[c]));
        let chi_square = absolute.residual_norm(0, &grouped).powi(2);
        let joined = self.prior.joined(&absolute, &vec![0.0; reduction.rank()])?;
        let covariance = spread_out(&inverse_gram(&joined.r), &reduction.kept, columns);
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
        let residuals = Residuals::of(&fitted, self.data)?;
        let warnings = warnings(&reduction, &outcome, self.observations, columns);
        Ok(Fit {
            fitted,
            reduction,
            noise: self.noise,
            residuals,
            factor: absolute,
            prior: self.prior,
            rounds: outcome.rounds,
            converged: outcome.converged,
            observations: self.observations,
            chi_square,
            solution: outcome.solution,
            warnings,
        })
    }
}

fn alike(old: &NoiseModel, new: &NoiseModel) -> bool {
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-3 * (a.abs() + b.abs()) + 1e-13;
    close(old.position_sd, new.position_sd)
        && close(old.visit_sd, new.visit_sd)
        && close(old.orientation_sd, new.orientation_sd)
}

/// (RᵀR)⁻¹ by solving with the triangle; never by an inverse of a Gram matrix.
fn inverse_gram(r: &DMatrix<f64>) -> DMatrix<f64> {
    let n = r.ncols();
    let inverse = r.solve_upper_triangular(&DMatrix::identity(n, n)).unwrap_or_else(|| DMatrix::zeros(n, n));
    &inverse * inverse.transpose()
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

fn warnings(reduction: &Reduction, outcome: &Outcome, observations: usize, columns: usize) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for (structural, decision) in [(true, &reduction.structural), (false, &reduction.practical)] {
        if !decision.is_clear() {
            warnings.push(Warning::UnclearRank { structural, gap: decision.gap });
        }
    }
    if observations < columns {
        warnings.push(Warning::FewerRowsThanUnknowns { observations, unknowns: columns });
    }
    if observations <= reduction.rank() {
        warnings.push(Warning::NoRedundancy);
    }
    if !outcome.converged {
        warnings.push(Warning::NotConverged { rounds: outcome.rounds });
    }
    warnings
}
