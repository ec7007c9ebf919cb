//! The closed loop: fit, find the residual, trace it to an effect that the model lacks, add it, again.

use crate::accept::model::Model;
use crate::accept::outcome::Outcome;
use crate::conclude::diagnosis::Diagnosis;
use crate::conclude::fallback;
use crate::conclude::fallback::{Checks, withdrawn};
use crate::conclude::final_fit::Plain;
use crate::conclude::interim::SoFar;
use crate::conclude::report::conclude;
use crate::conclude::whole::Whole;
use crate::data::derived;
use crate::data::sample::sample;
use crate::error::DiscoverError;
use crate::model::current::Ground;
use crate::model::{installation, wide};
use crate::observer::Begin;
use crate::options::DiscoverOptions;
use crate::progress::Progress;
use crate::search::search;
use truepose_errormodel::{AnyEffect, Dataset, Visits};
use truepose_identify::{Answer, FitOptions, PriorStrength, hold_out, place, proceed};
use truepose_kinematics::Chain;
use truepose_solvers::Solver;

/// Fewest poses with which a search makes sense.
const FEWEST: usize = 12;

/// Runs the closed loop.
///
/// `declared` are the effects that the user says the robot has; everything else is the residual's to show. What is found is
/// withdrawn, and the declared model stands, when it predicts data that the search has not seen worse than the declared model does.
///
/// # Errors
/// When the model does not fit the data, nothing was measured, there are too few visits, or an option is out of its range.
pub fn diagnose<A: Answer>(
    chain: &Chain,
    declared: &[Box<dyn AnyEffect>],
    data: &Dataset,
    solver: &dyn Solver,
    options: &DiscoverOptions,
    observer: &(dyn Fn(Progress) -> A + Sync),
) -> Result<Diagnosis, DiscoverError> {
    options.validate()?;
    // History is made on the whole record, before anything is drawn from it.
    let data = &derived::with_derived(data);
    let rows = hold_out(data, options.holdout, options.seed)?;
    on_split(chain, declared, (data, rows), solver, options, Checks::ALL, &|step| {
        Ok(proceed(observer(step))?)
    })
}

/// Runs the closed loop on given training rows, and judges it on the others.
pub(crate) fn on_split(
    chain: &Chain,
    declared: &[Box<dyn AnyEffect>],
    (data, (train_rows, holdout_rows)): (&Dataset, (Vec<usize>, Vec<usize>)),
    solver: &dyn Solver,
    options: &DiscoverOptions,
    checks: Checks,
    progress: &Begin<'_>,
) -> Result<Diagnosis, DiscoverError> {
    let train = data.select(&train_rows);
    progress(Progress::Fitting)?;
    let placement = place(chain, &train)?;
    let part = sample(&train, options.seed);
    let open = installation::with_unknown(chain, declared)?;
    let declared_fit = FitOptions { flat: FitOptions::default().flat, ..options.fit.clone() };
    let chain_placed = &placement.chain;
    let mut context =
        Ground { chain: chain_placed, declared: &open, data: &part, solver, fit: declared_fit, options };
    let mut first = context.working(Vec::new(), &[])?;
    // How far the declared errors lie from what was expected of them is not for the finds to say.
    let wide = wide::as_fitted(&open, &first.fit);
    context.fit = options.fit.clone();
    if matches!(context.fit.prior, PriorStrength::Evidence | PriorStrength::VarianceGroups) {
        context.declared = &wide;
        context.fit.prior = PriorStrength::Fixed(first.fit.prior.kappa);
        first = context.working(Vec::new(), &first.outliers.suspects)?;
    }
    let have = Visits::of(&train).len();
    if have < FEWEST {
        let rank = first.fit.reduction.rank();
        return Err(DiscoverError::TooFewVisits { have, rank, need: FEWEST });
    }
    let whole_fit = FitOptions { flat: FitOptions::default().flat, ..options.fit.clone() };
    let plain = Plain { declared: &open, fit: whole_fit, thorough: checks.test_set };
    let whole = Whole { data, train_rows, holdout_rows, placement: placement.clone() };
    let mut told = SoFar::new(&first, &whole)?;
    let mut interim =
        |outcome: &Outcome| progress(Progress::SoFar(Box::new(told.after(&context, outcome, &whole)?)));
    let mut outcome = search(&context, Model::declared(first), progress, &mut interim)?;
    progress(Progress::Checking)?;
    let mut unsearched = None;
    let all_rows = Ground { data: &train, ..context.clone() };
    let mut context = &context;
    if part.len() < train.len() {
        unsearched = Some(fallback::unsearched(&outcome.model, &train, options.seed)?);
        // What was found in a part of the data is fitted to all of it.
        outcome.model = outcome.model.on_data_of(&all_rows)?;
        context = &all_rows;
    }
    outcome.model = outcome.model.between_rows(context)?;
    let again =
        |rows, checks| on_split(chain, declared, (&train, rows), solver, options, checks, &|_| Ok(()));
    let withdrawn = withdrawn(context, &outcome.model, &whole, (&train, unsearched), checks, &again)?;
    if withdrawn.is_some() {
        outcome.model = outcome.model.without_findings();
    }
    progress(Progress::Judging)?;
    conclude(context, outcome, whole, withdrawn, &plain)
}
