//! The closed loop: fit, find the residual, trace it to an effect that the model lacks, add it, again.

use crate::diagnosis::Diagnosis;
use crate::fallback::{Checks, withdrawn};
use crate::final_fit::Plain;
use crate::observer::Begin;
use crate::sample::sample;
use crate::search::Search;
use crate::working::Ground;
use crate::{DiscoverError, DiscoverOptions, conclude, derived, fallback, installation, wide};
use truepose_errormodel::{AnyEffect, Dataset, Visits};
use truepose_identify::{Answer, FitOptions, PriorStrength, hold_out, place, proceed};
use truepose_kinematics::Chain;
use truepose_solvers::Solver;

/// Where a discovery is, for a progress bar.
#[derive(Debug, Clone)]
pub enum Progress {
    /// Fitting the declared model.
    Fitting,
    /// Screening all candidates, so many effects having been found.
    Screening(usize),
    /// An effect was added.
    Found(String),
    /// What there is after each find, for whoever interrupts the loop: fitted to the training rows, without rivals.
    SoFar(Box<Diagnosis>),
    /// Looking at earlier finds again.
    Reconsidering,
    /// Holding the enlarged model against the declared one on data that it has not seen.
    Checking,
    /// Judging the result on the rows that were drawn out first.
    Judging,
}

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
    let mut ground =
        Ground { chain: &placement.chain, declared: &open, data: &part, solver, fit: declared_fit };
    let mut first = ground.working(Vec::new(), &[])?;
    // How far the declared errors lie from what was expected of them is not for the finds to say.
    let wide = wide::as_fitted(&open, &first.fit);
    ground.fit = options.fit.clone();
    if matches!(ground.fit.prior, PriorStrength::Evidence | PriorStrength::Kinds) {
        ground.declared = &wide;
        ground.fit.prior = PriorStrength::Fixed(first.fit.prior.kappa);
        first = ground.working(Vec::new(), &first.outliers.suspects)?;
    }
    let have = Visits::of(&train).len();
    if have < FEWEST {
        let rank = first.fit.reduction.rank();
        return Err(DiscoverError::TooFewVisits { have, rank, need: FEWEST });
    }
    let whole_fit = FitOptions { flat: FitOptions::default().flat, ..options.fit.clone() };
    let mut search = Search::new(ground, options, first);
    let plain = Plain { declared: &open, fit: whole_fit, thorough: checks.test_set };
    let whole = conclude::Whole { data, train_rows, holdout_rows, placement: placement.clone() };
    let (stopped, last) = search.run(&whole, progress)?;
    progress(Progress::Checking)?;
    let mut unsearched = None;
    if part.len() < train.len() {
        unsearched = Some(fallback::unsearched(&search, &train)?);
        // What was found in a part of the data is fitted to all of it.
        search.go_over_to(&train)?;
    }
    search.between_rows()?;
    let again =
        |rows, checks| on_split(chain, declared, (&train, rows), solver, options, checks, &|_| Ok(()));
    let withdrawn = withdrawn(&mut search, &whole, (&train, unsearched), checks, &again)?;
    progress(Progress::Judging)?;
    conclude::conclude(search, whole, (stopped, last), withdrawn, &plain)
}
