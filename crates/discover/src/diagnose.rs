//! The closed loop of discovery: fit, search, validation against the declared model, result.

use crate::accept::model::Model;
use crate::accept::outcome::Outcome;
use crate::census::Census;
use crate::conclude::diagnosis::Diagnosis;
use crate::conclude::fallback;
use crate::conclude::fallback::{Checks, Unseen};
use crate::conclude::final_fit::DeclaredFit;
use crate::conclude::interim::InterimReport;
use crate::conclude::partition::{HeldOut, Partition};
use crate::conclude::report::conclude;
use crate::conclude::stated::StatedScale;
use crate::data::derived;
use crate::data::sample::{is_sampled, sample};
use crate::error::DiscoverError;
use crate::model::current::{Context, ModelFit};
use crate::model::{installation, wide};
use crate::observer::Begin;
use crate::options::DiscoverOptions;
use crate::progress::Progress;
use crate::search::search;
use crate::widened::Partitioned;
use std::borrow::Cow;
use truepose_errormodel::{AnyEffect, Dataset, Visits};
use truepose_identify::{Answer, FitOptions, PriorStrength, hold_out, place, proceed};
use truepose_kinematics::Chain;
use truepose_solvers::Solver;

/// Runs the closed loop.
///
/// `declared` are the effects of the declared model; `chain` is the nominal robot; `data` has joint values in
/// rad or m, positions in m. A fraction `options.holdout` of the configurations is the test set, drawn before
/// anything is fitted; where poses are few, nested folds take its place ([`HeldOut`]). All findings are withdrawn, and the result is the declared model, when the enlarged
/// model predicts unseen data worse. Same inputs and seed, same
/// result, whatever the number of threads. Method: section 8 of docs/method.md.
///
/// # Errors
/// When the model does not fit the data, nothing was measured, there are fewer than 12 training poses, or an
/// option is out of its range.
pub fn diagnose<A: Answer>(
    chain: &Chain,
    declared: &[Box<dyn AnyEffect>],
    data: &Dataset,
    solver: &dyn Solver,
    options: &DiscoverOptions,
    observer: &(dyn Fn(Progress) -> A + Sync),
) -> Result<Diagnosis, DiscoverError> {
    options.validate()?;
    // Lagged channels need the whole record: they are derived before the test set is drawn.
    let data = &derived::with_derived(data, declared, &options.policy);
    let left = ((1.0 - options.policy.test_set) * Visits::of(data).len() as f64) as usize;
    let few = left < options.policy.few_poses && !is_sampled(data.len(), options.budget.sample_rows);
    let rows = match options.holdout {
        None if few => ((0..data.len()).collect(), (0..data.len()).collect()),
        fraction => hold_out(data, fraction.unwrap_or(options.policy.test_set), options.seed)?,
    };
    on_split(chain, declared, (data, rows), solver, options, Checks::All, &|step| {
        Ok(proceed(observer(step))?)
    })
}

/// How often stated standard deviations are scaled: with the residuals of the declared model, of the enlarged one, and of the one found then.
const SCALINGS: usize = 3;

/// Runs the search on given (training, test) rows. Where the stated standard deviations turn out to exceed the scatter it begins again with
/// smaller ones.
pub(crate) fn on_split(
    chain: &Chain,
    declared: &[Box<dyn AnyEffect>],
    (data, rows): (&Dataset, (Vec<usize>, Vec<usize>)),
    solver: &dyn Solver,
    options: &DiscoverOptions,
    checks: Checks,
    progress: &Begin<'_>,
) -> Result<Diagnosis, DiscoverError> {
    let mut scale = StatedScale::default();
    let mut scalings = 0;
    let all = Partitioned { data, rows: &rows };
    let part = all.part(options.seed, options.budget.fitted_rows);
    loop {
        let applied =
            |data| if scale.is_one() { Cow::Borrowed(data) } else { Cow::Owned(scale.applied(data)) };
        let may_scale = scalings < SCALINGS;
        let done = match &part {
            None => {
                let run = Run { chain, declared, solver, options, checks, scale, may_scale, all: None };
                attempt(&run, (&applied(data), rows.clone()), progress)?
            }
            Some(part) => {
                let whole = applied(data);
                let all = Partitioned { data: &whole, rows: &rows };
                let run = Run { chain, declared, solver, options, checks, scale, may_scale, all: Some(&all) };
                match attempt(&run, (&applied(&part.data), part.rows.clone()), progress)? {
                    Attempt::Done(found) => Attempt::Done(Box::new(part.widened(*found, &all, options)?)),
                    again => again,
                }
            }
        };
        match done {
            Attempt::Done(found) => return Ok(*found),
            Attempt::Overstated(factor) => scale = scale.times(factor),
        }
        scalings += 1;
    }
}

/// Inputs of a run.
struct Run<'a> {
    chain: &'a Chain,
    declared: &'a [Box<dyn AnyEffect>],
    solver: &'a dyn Solver,
    options: &'a DiscoverOptions,
    checks: Checks,
    scale: StatedScale,
    may_scale: bool,
    /// All rows, where the run is given a part of them.
    all: Option<&'a Partitioned<'a>>,
}

enum Attempt {
    Done(Box<Diagnosis>),
    Overstated(StatedScale),
}

fn attempt(
    run: &Run<'_>,
    (data, (train_rows, holdout_rows)): (&Dataset, (Vec<usize>, Vec<usize>)),
    progress: &Begin<'_>,
) -> Result<Attempt, DiscoverError> {
    let Run { chain, declared, solver, options, checks, scale, may_scale, all } = *run;
    let train = data.select(&train_rows);
    progress(Progress::Fitting)?;
    let placement = place(chain, &train)?;
    let part = sample(&train, options.seed, options.budget.sample_rows);
    let open = installation::with_unknown(chain, declared)?;
    let declared_options = FitOptions { flat: FitOptions::default().flat, ..options.fit.clone() };
    let chain_placed = &placement.chain;
    let mut context = Context {
        chain: chain_placed,
        declared: &open,
        data: &part,
        solver,
        fit: declared_options,
        options,
        levels_first: true,
        full_report: checks == Checks::All,
    };
    let mut first = context.fit_model(Vec::new(), &[])?;
    // The prior widths of declared errors come from the declared model alone; findings do not change them.
    let wide = wide::as_fitted(&open, &first.fit);
    context.fit = options.fit.clone();
    if matches!(context.fit.prior, PriorStrength::Evidence | PriorStrength::VarianceGroups) {
        context.declared = &wide;
        context.fit.prior = PriorStrength::Fixed(first.fit.prior.kappa);
        first = context.fit_model(Vec::new(), &first.outliers.suspects)?;
    }
    let overstated = |fit: &ModelFit| StatedScale::of(&fit.fit, &fit.data).filter(|_| may_scale);
    if let Some(factor) = overstated(&first) {
        return Ok(Attempt::Overstated(factor));
    }
    let have = Visits::of(&train).len();
    if have < options.policy.fewest_poses {
        let rank = first.fit.reduction.rank();
        return Err(DiscoverError::TooFewPoses { have, rank, need: options.policy.fewest_poses });
    }
    let final_options = FitOptions { flat: FitOptions::default().flat, ..options.fit.clone() };
    let declared_fit =
        DeclaredFit { declared: &open, fit: final_options, full_report: checks == Checks::All };
    let held_out = if train_rows.len() < data.len() { HeldOut::TestSet } else { HeldOut::NestedFolds };
    let placement = placement.clone();
    let partition = Partition { data, train_rows, holdout_rows, held_out, placement, stated_scale: scale };
    let mut interim_report = InterimReport::new(&first, &partition, scale)?;
    let mut interim = |outcome: &Outcome| {
        progress(Progress::Interim(Box::new(interim_report.after(&context, outcome, &partition)?)))
    };
    let mut outcome = search(&context, Model::declared(first), progress, &mut interim)?;
    let mut admitted = false;
    if !outcome.model.current.outliers.admitted.is_empty() {
        // No effect explains what rows with one payload have: they are outliers.
        let again = Context { levels_first: false, ..context.clone() };
        let first = again.fit_model(Vec::new(), &[])?;
        outcome = search(&again, Model::declared(first), progress, &mut interim)?;
        admitted = true;
    }
    if let Some(factor) = overstated(&outcome.model.current) {
        return Ok(Attempt::Overstated(factor));
    }
    context.levels_first &= !admitted;
    progress(Progress::Checking)?;
    let (mut unsearched, mut before_census) = (None, None);
    let all_rows = Context { data: &train, ..context.clone() };
    let mut context = &context;
    if part.len() < train.len() {
        unsearched = Some(fallback::unsearched(context, &outcome.model, &train)?);
        let every = match all {
            Some(all) => Cow::Owned(all.data.select(&all.rows.0)),
            None => Cow::Borrowed(&train),
        };
        let census = Census::new((context, &all_rows), every, &outcome)?;
        let searched = outcome.clone();
        outcome = census.of(outcome, progress)?;
        outcome.model = census.settled(&outcome.model)?;
        if outcome.model.findings.len() > searched.model.findings.len() {
            before_census = Some((census, searched));
        }
        context = &all_rows;
    }
    outcome.model = outcome.model.between_rows(context)?;
    let inner = &fallback::of_fold(options);
    let again = |rows| on_split(chain, declared, (&train, rows), solver, inner, Checks::OfFold, &|_| Ok(()));
    let nested = fallback::nested(context, &outcome.model, (&partition, &train), checks, &again)?;
    let held = |model: &Model| all.map(|all| all.held_out_errors(model)).transpose();
    let mut unseen = Unseen { unsearched, nested, held: held(&outcome.model)? };
    let mut withdrawn = fallback::withdrawn(context, &outcome.model, &partition, &unseen, checks)?;
    // What the census added may be at fault: the findings of the search are judged without it.
    if withdrawn.is_some()
        && let Some((census, searched)) = before_census.take()
    {
        outcome = Outcome { model: census.settled(&searched.model)?, ..searched };
        unseen.held = held(&outcome.model)?;
        withdrawn = fallback::withdrawn(context, &outcome.model, &partition, &unseen, checks)?;
    }
    drop(before_census);
    if withdrawn.is_some() {
        outcome.model = outcome.model.without_findings();
    }
    progress(Progress::Judging)?;
    let withdrawn = (withdrawn, unseen.nested);
    Ok(Attempt::Done(Box::new(conclude(context, outcome, partition, withdrawn, &declared_fit)?)))
}
