//! The search: screen, compare, test, add, revise; repeated until no further effect is significant.

use crate::accept::admit::{admitted, without_insignificant};
use crate::accept::evidence::Refused;
use crate::accept::model::Model;
use crate::accept::outcome::{LastScreen, Outcome};
use crate::accept::winner::winner;
use crate::error::DiscoverError;
use crate::history::History;
use crate::model::current::Context;
use crate::observer::Begin;
use crate::problem::joint_noise::joint_repeatability;
use crate::problem::linearisation::Linearisation;
use crate::progress::Progress;
use crate::revise::naming::named;
use crate::revise::revision::{after_finding, descended, reconsidered_once};
use crate::screen::candidates::Screen;
use crate::screen::multiplicity::Multiplicity;
use crate::screen::untestable::untestable;
use crate::significance::rotation::NullDistribution;
use crate::termination::Termination;

/// Adds effects until no candidate passes all tests. `interim` is called with the outcome after each finding.
pub(crate) fn search(
    context: &Context<'_>,
    declared: Model,
    progress: &Begin<'_>,
    interim: &mut dyn FnMut(&Outcome) -> Result<(), DiscoverError>,
) -> Result<Outcome, DiscoverError> {
    let options = context.options;
    let mut history = History::default();
    let mut outcome = Outcome::of(declared);
    let mut known: Option<NullDistribution> = None;
    loop {
        progress(Progress::Screening(outcome.model.findings.len()))?;
        let current = outcome.model.current.clone();
        let mut linearisation = Linearisation::new(&current.fit, &current.data, options)?;
        if history.wanders() {
            linearisation = linearisation.beside_wander(options.seed);
        }
        if let Some(found) = &mut outcome.joints {
            linearisation = linearisation.beside_joints(found.joints);
            *found = found.under(&linearisation);
        }
        let screen = Screen::new(&linearisation, &options.library, &current.found);
        let (multiplicity, p_value) = Multiplicity::of(&linearisation, &screen, known.take(), options)?;
        let detectable_gain = multiplicity.null.detectable(options.alpha, linearisation.len());
        outcome.last = LastScreen { p_value, detectable_gain };
        known = Some(multiplicity.null.clone());
        let stop = history.decide(p_value, &outcome.model, options);
        let found = match stop {
            Some(_) => false,
            None => add(
                context,
                &mut outcome,
                &mut history,
                (&linearisation, &screen, &multiplicity.null),
                progress,
            )?,
        };
        if found {
            if history.may_revise(&outcome.model, context.budget().reconsidered) {
                progress(Progress::Reconsidering)?;
                outcome.model = after_finding(context, outcome.model, &multiplicity)?;
            }
            interim(&outcome)?;
            continue;
        }
        if history.may_descend(&outcome.model) {
            let changed;
            (outcome.model, changed) = descended(context, outcome.model)?;
            if changed {
                continue;
            }
        }
        if history.may_reconsider(&outcome.model, context.budget().reconsidered) {
            progress(Progress::Reconsidering)?;
            let changed;
            (outcome.model, changed) = reconsidered_once(context, outcome.model, &multiplicity)?;
            if changed {
                // The revised model may have further significant candidates.
                continue;
            }
        }
        // No effect explains why poses depend on those before: it is noise, beside which the search goes on.
        if history.may_wander(stop) && linearisation.is_dependent(options.seed) {
            continue;
        }
        // Nor why poses scatter as they do: neither alike everywhere nor along all axes.
        if history.may_scatter(stop)
            && let Some(found) = joint_repeatability(&linearisation)
        {
            outcome.joints = Some(found);
            continue;
        }
        if context.full_report {
            outcome.untestable = untestable(&linearisation, &screen, outcome.last.detectable_gain);
        }
        outcome.model = named(context, outcome.model)?;
        let dropped;
        (outcome.model, dropped) = without_insignificant(context, outcome.model, &mut outcome.refused)?;
        if !dropped.is_empty() {
            // What they explained is left over: another cause may explain it.
            history.drop(dropped);
            continue;
        }
        outcome.stopped = stop.unwrap_or(match p_value > options.alpha {
            true => Termination::NothingLeft,
            false => Termination::NothingConvincing,
        });
        return Ok(outcome);
    }
}

/// Adds the best candidate that passes the tests of the linearised problem and those of the refitted model;
/// whether there was one.
fn add(
    context: &Context<'_>,
    outcome: &mut Outcome,
    history: &mut History,
    screened: (&Linearisation<'_>, &Screen, &NullDistribution),
    progress: &Begin<'_>,
) -> Result<bool, DiscoverError> {
    for _ in 0..context.budget().failures {
        let current = &outcome.model.current;
        let Some(accepted) = winner(context, current, screened, &history.barred, &mut outcome.refused)?
        else {
            return Ok(false);
        };
        let (candidate, evidence) = (accepted.candidate.clone(), accepted.evidence.clone());
        progress(Progress::Found(candidate.words()))?;
        match admitted(context, &outcome.model, accepted)? {
            Ok(model) => {
                history.begin_again();
                outcome.model = model;
                return Ok(true);
            }
            Err(doubt) => {
                let refused = Refused { candidate: candidate.clone(), evidence, doubt };
                refused.note_in(&mut outcome.refused);
                history.barred.push(candidate);
            }
        }
    }
    Ok(false)
}
