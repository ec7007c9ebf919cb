//! The fit: reduce, solve, re-linearise at the exact robot, until nothing moves (Eq. 18–19, and beyond).
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | c | coefficients of the model | p | each its own |
//! | β | grouped errors, c = B β | r | as the kept column |
//! | A | whitened design matrix at c | m × p | 1 per unit |
//! | r | whitened y − y(c) | m | 1 |
//! | W | prior, see [`crate::Prior`] | r × r | 1 per unit |
//!
//! Each round solves `min ‖A B β − (r + A c)‖² + ‖W β‖²` for the grouped errors themselves, not for their change: so a
//! solver with bounds means the errors. The second term leaves alone what the data determines, and keeps directions
//! that it hardly excites from running away: the posterior standard deviation of a direction is never above its
//! prior one. A step that makes things worse is taken back and damped (Levenberg, Marquardt). The first round
//! alone, without a prior, is the paper's linear fit.
//!
//! An error may act only where others have moved the robot: a turn about an axis that nominally goes through the target. What
//! the reduction at the nominal robot leaves out is looked at again at the solution, and taken in where the data determines
//! it better than its expected size.

mod believed;
mod constraints;
mod rounds;
mod warnings;

use crate::reduction::{Reduction, grouped, reduce};
use crate::shapes::{self, FittedShape, Shapes};
use crate::{Freedom, IdentifyError, NoiseModel, Prior, PriorStrength, Residuals, Spread};
use believed::without_doubted;
use rounds::State;
pub(crate) use rounds::from_factor;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};
use truepose_errormodel::{Dataset, ErrorModel, FittedModel, Visits};
use truepose_solvers::accumulator::Factor;
use truepose_solvers::{Need, PivotedQr, RankRule, Solution, SolveError, Solver};

/// How to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitOptions {
    /// Re-linearise until nothing moves; otherwise the paper's single linear step.
    pub refine: bool,
    /// Rounds at most.
    pub max_rounds: usize,
    /// Look at the reduction again where the rounds end, and take in what the data determines there though not at the nominal robot;
    /// otherwise what is left out at the nominal robot is left out for good, as in the paper.
    pub second_look: bool,
    /// Three rounds in turn that gain less than this of the objective, in units (1 is a standard deviation of one number), end the fit
    /// where no unknown moves by a tenth of its standard deviation any more: the floor of a flat valley.
    pub flat: f64,
    /// How ranks are decided.
    pub rank: RankRule,
    /// How strongly coefficients are held to their expected sizes.
    pub prior: PriorStrength,
    /// Where standard deviations come from.
    pub noise: NoiseSource,
    /// What is done about parameters in which an effect is not linear and that it leaves free.
    pub shapes: Shapes,
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
            second_look: true,
            flat: 1e-3,
            rank: RankRule::Default,
            prior: PriorStrength::Kinds,
            noise: NoiseSource::Estimate,
            shapes: Shapes::default(),
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
        if !(self.flat >= 0.0 && self.flat < 1.0) {
            return Err(IdentifyError::Option {
                option: "flat",
                value: self.flat,
                expected: "from 0 to below 1",
            });
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
    /// Whether the last round moved nothing any more; always of a single linear step, which is meant to be one.
    pub converged: bool,
    /// Whether rounds went on at the exact robot; otherwise this is a single linear step.
    pub refined: bool,
    /// Measured numbers m.
    pub observations: usize,
    /// Sum of whitened squares at the solution.
    pub chi_square: f64,
    /// What the solver said last.
    pub solution: Solution,
    /// Parameters in which effects are not linear, where they were looked for; the model of `fitted` holds their values.
    pub shapes: Vec<FittedShape>,
    /// What was left to scatter where the noise was estimated; none where it was given, or comes from other rows.
    pub scatter: Option<Freedom>,
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
    /// An unknown that is no constant error has no effect on anything in this data (no load, a channel that never moves).
    NoEffect {
        /// The column's name.
        column: String,
    },
    /// The best value of a shape parameter lies at an end of the range in which it was looked for.
    ShapeAtBound {
        /// The effect's family.
        effect: String,
        /// The parameter.
        name: String,
        /// Where it lies.
        value: f64,
    },
    /// A coefficient lies outside of its bounds by more than its 95 % interval; a solver that holds bounds would hold it.
    OutOfBounds {
        /// The column's name.
        column: String,
        /// The coefficient.
        value: f64,
        /// Its bounds.
        bounds: [f64; 2],
    },
    /// A solver that takes or leaves whole effects left one out: all of its coefficients are zero.
    LeftOut {
        /// The effect's family.
        effect: String,
        /// The name of its first column.
        column: String,
    },
    /// What a robust solver found was worse than plain least squares, and was not taken: this is the plain fit.
    FellBack {
        /// The solver's name.
        solver: String,
        /// By what it was refused.
        why: Refusal,
    },
    /// A strategy predicts configurations that it did not see worse than plain least squares does.
    WorseThanPlain {
        /// The solver's name.
        solver: String,
        /// Its bounded held-out error over that of plain least squares.
        ratio: f64,
    },
    /// As many unknowns as numbers: the residual says nothing about the accuracy.
    NoRedundancy,
}

/// By what a robust fit was refused.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refusal {
    /// It leaves more than plain least squares, by a robust measure on the data of the fit.
    Objective,
    /// It predicts what it did not see worse, by so much: its bounded held-out error over that of plain least squares.
    HeldOut(f64),
}

impl Fit {
    /// Degrees of freedom of the noise that intervals rest on, at least one: where visits share what differs from one to the next, those
    /// between visits, for more rows of a visit say no more about it; otherwise m − r.
    pub fn degrees_of_freedom(&self) -> usize {
        let shapes = self.shapes.len();
        let all = self.observations.saturating_sub(self.reduction.rank() + shapes);
        let between =
            self.scatter.filter(|_| self.noise.visit_sd > 0.0).map(|left| left.between.round() as usize);
        between.map_or(all, |between| between.saturating_sub(shapes).min(all)).max(1)
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

/// Quantile of Student's t. Of many degrees of freedom from the normal distribution's z, as Fisher and Cornish (1960) expand it: right to
/// 1e-11, where an inverse of the incomplete beta function may look for ever.
///
/// ```text
/// t ≈ z + (z³ + z)/4ν + (5z⁵ + 16z³ + 3z)/96ν²
/// ```
pub fn student_quantile(probability: f64, freedom: usize) -> f64 {
    const MANY: usize = 10_000;
    let nu = freedom as f64;
    if freedom < MANY {
        return StudentsT::new(0.0, 1.0, nu).map_or(1.96, |t| t.inverse_cdf(probability));
    }
    let z = Normal::standard().inverse_cdf(probability);
    let square = z * z;
    z + z * (square + 1.0) / (4.0 * nu) + z * (5.0 * square * square + 16.0 * square + 3.0) / (96.0 * nu * nu)
}

/// Fits a model to data, with the shape parameters that its effects leave free and the groups of a polynomial that reduces
/// first: the model of [`Fit::fitted`] holds them.
///
/// # Errors
/// When the data does not fit the model, nothing was measured, or the solver refuses.
pub fn fit(
    model: &ErrorModel,
    data: &Dataset,
    solver: &dyn Solver,
    options: &FitOptions,
) -> Result<Fit, IdentifyError> {
    options.validate()?;
    let model = &*grouped(model, data, options.rank)?;
    if options.shapes != Shapes::Fixed && shapes::wanted(model) {
        return shapes::fit(model, data, solver, options);
    }
    fit_fixed(model, &*data.derived_for(model)?, solver, options)
}

/// Fits a model as it stands.
pub(crate) fn fit_fixed(
    model: &ErrorModel,
    data: &Dataset,
    solver: &dyn Solver,
    options: &FitOptions,
) -> Result<Fit, IdentifyError> {
    let visits = Visits::of(data);
    // Solvers whose objective only they know begin where plain squares end.
    let plain = PivotedQr::default();
    let follows = options.refine && !guarded(solver);
    let first: &dyn Solver = if follows { &plain } else { solver };
    let mut begin = options.clone();
    if follows && !solver.supports(Need::Unpenalised) && options.prior == PriorStrength::None {
        begin.prior = PriorStrength::Evidence;
    }
    let mut state = State::new(model, data, &visits, first, &begin)?;
    let factor = state.linearise(None)?;
    let mut reduction = reduce(model, data, &factor, options.rank, &state.coefficients)?;
    state.prior = Prior::new(model, &reduction, begin.prior);
    let mut outcome = state.rounds(&reduction, factor.select(&reduction.kept))?;
    if options.refine
        && options.second_look
        && let Some(more) = state.looked_at_again(&reduction, &outcome)?
    {
        // The same width as before, until the data is asked again.
        let before = state.spoilable();
        state.prior = Prior::wide(model, &more, before.0.kappa, before.0.widths.clone());
        state.share_out(&reduction, &more);
        let factor = state.linearise(Some(&more.kept))?;
        match state.rounds(&more, factor) {
            Ok(further) => (reduction, outcome) = (more, further),
            // What was taken in ran away until nothing was a number any more: the fit without it stands.
            Err(IdentifyError::Solve(SolveError::NotFinite { .. })) => state.back_to(before),
            Err(error) => return Err(error),
        }
    }
    let mut taken = true;
    if follows {
        let prior = match options.prior {
            PriorStrength::None => Prior::new(model, &reduction, PriorStrength::None),
            _ => state.prior.clone(),
        };
        state.options.prior = options.prior;
        (outcome, taken) = state.follow(solver, prior, &reduction, outcome)?;
        if taken && solver.supports(Need::Outliers) {
            outcome = without_doubted(&mut state, data, solver, options, &reduction, outcome)?;
        }
    }
    let mut fit = state.finish(reduction, outcome)?;
    if !taken {
        fit.warnings.push(Warning::FellBack { solver: solver.name().into(), why: Refusal::Objective });
    }
    Ok(fit)
}

/// Whether what a solver minimises is known: squares and the prior, nothing else.
pub(crate) fn guarded(solver: &dyn Solver) -> bool {
    solver.supports(Need::Unpenalised) && !solver.supports(Need::Outliers)
}

/// Fits with a reduction and a prior that are already known; nothing about the structure is decided again, and shape
/// parameters stay as they are in the model.
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
    refit_from(model, data, solver, options, (reduction, prior, None))
}

/// Fits the model of a fit to other data of the same robot: with its reduction and its prior, from where it ended.
///
/// # Errors
/// As [`fit`].
pub fn fit_again(
    known: &Fit,
    data: &Dataset,
    solver: &dyn Solver,
    options: &FitOptions,
) -> Result<Fit, IdentifyError> {
    let start = known.fitted.coefficients();
    refit_from(known.fitted.model(), data, solver, options, (&known.reduction, &known.prior, Some(start)))
}

fn refit_from(
    model: &ErrorModel,
    data: &Dataset,
    solver: &dyn Solver,
    options: &FitOptions,
    (reduction, prior, start): (&Reduction, &Prior, Option<&[f64]>),
) -> Result<Fit, IdentifyError> {
    let data = &*data.derived_for(model)?;
    let visits = Visits::of(data);
    let plain = PivotedQr::default();
    let follows = options.refine && !guarded(solver);
    let first: &dyn Solver = if follows { &plain } else { solver };
    let mut state = State::new(model, data, &visits, first, options)?;
    state.prior = prior.clone();
    state.options.prior = PriorStrength::Fixed(prior.kappa);
    if let Some(start) = start {
        state.coefficients.copy_from_slice(start);
    }
    state.unseen = start.is_none();
    let factor = state.linearise(Some(&reduction.kept))?;
    let known = follows && start.is_some();
    let mut outcome = if known { state.here(reduction, factor)? } else { state.rounds(reduction, factor)? };
    let mut taken = true;
    if follows {
        (outcome, taken) = state.follow(solver, prior.clone(), reduction, outcome)?;
    }
    let mut fit = state.finish(reduction.clone(), outcome)?;
    if !taken {
        fit.warnings.push(Warning::FellBack { solver: solver.name().into(), why: Refusal::Objective });
    }
    Ok(fit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_many_degrees_of_freedom_go_on_where_those_of_few_end() {
        for probability in [0.6, 0.975, 0.9995] {
            let exact = StudentsT::new(0.0, 1.0, 10_000.0).unwrap().inverse_cdf(probability);
            assert!((student_quantile(probability, 10_000) - exact).abs() < 1e-9, "{probability}");
        }
        // It comes to an end, and near the normal distribution's 1.959 963 985.
        assert!((student_quantile(0.975, 30_000_000) - 1.959_963_985).abs() < 1e-6);
    }
}
