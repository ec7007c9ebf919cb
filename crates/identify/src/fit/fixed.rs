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

use super::believed::without_doubted;
use super::objective::guarded;
use super::options::FitOptions;
use super::result::Fit;
use super::rounds::State;
use super::warnings::{Refusal, Warning};
use crate::reduction::{Reduction, reduce};
use crate::{IdentifyError, Prior, PriorStrength};
use truepose_errormodel::{Dataset, ErrorModel, Visits};
use truepose_solvers::{Need, PivotedQr, SolveError, Solver};

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
        && options.second_reduction
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

/// Fits with a reduction and a prior that are already known; nothing about the structure is decided again, and shape
/// parameters stay as they are in the model.
///
/// # Errors
/// As [`crate::fit`].
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
/// As [`crate::fit`].
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
