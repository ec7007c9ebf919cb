//! The loop: screen, compare, test, add, revise; again, until no further effect is significant.

use crate::accept::admit::{admitted, sifted};
use crate::accept::evidence::Refused;
use crate::accept::model::Model;
use crate::accept::outcome::{LastScreen, Outcome};
use crate::accept::winner::{seen_from, winner};
use crate::error::DiscoverError;
use crate::model::current::Ground;
use crate::observer::Begin;
use crate::problem::linearisation::Scene;
use crate::progress::Progress;
use crate::revise::revision::{after_finding, descended, reconsidered_once};
use crate::screen::candidates::Screen;
use crate::screen::untestable::untestable;
use crate::significance::sign_flips::NullDistribution;
use crate::termination::{History, Stop};

/// With more findings than this they are reconsidered only at the end.
const FEW: usize = 4;

/// Adds effects until none is left that passes all tests. `interim` sees the outcome after each finding.
pub(crate) fn search(
    context: &Ground<'_>,
    declared: Model,
    progress: &Begin<'_>,
    interim: &mut dyn FnMut(&Outcome) -> Result<(), DiscoverError>,
) -> Result<Outcome, DiscoverError> {
    let options = context.options;
    let mut history = History::default();
    let mut outcome = Outcome::of(declared);
    loop {
        progress(Progress::Screening(outcome.model.findings.len()))?;
        let current = outcome.model.current.clone();
        let scene = Scene::new(&current.fit, &current.data)?;
        let screen = Screen::new(&scene, &options.without, &current.found);
        let asked = screen.questions();
        if history.first() {
            outcome.untestable = untestable(&scene, &screen);
        }
        let null = screen.null(options.flips, options.seed);
        let p_value = null.p_value(screen.largest());
        outcome.last = LastScreen { p_value, detectable_gain: seen_from(&null, options.alpha) };
        let stop = history.decide(p_value, &outcome.model, options);
        let found = match stop {
            Some(_) => false,
            None => add(context, &mut outcome, &mut history, (&scene, &screen, &null), progress)?,
        };
        if found {
            if history.may_revise(&outcome.model, FEW) {
                progress(Progress::Reconsidering)?;
                outcome.model = after_finding(context, outcome.model, asked)?;
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
        if history.may_reconsider(&outcome.model, FEW) {
            progress(Progress::Reconsidering)?;
            let changed;
            (outcome.model, changed) = reconsidered_once(context, outcome.model, asked)?;
            if changed {
                // There may be more to find.
                continue;
            }
        }
        outcome.model = sifted(context, outcome.model, &mut outcome.refused)?;
        outcome.stopped = stop.unwrap_or(Stop::NothingConvincing);
        return Ok(outcome);
    }
}

/// Adds the best candidate that passes all tests, also as part of the refitted model; whether there was one.
fn add(
    context: &Ground<'_>,
    outcome: &mut Outcome,
    history: &mut History,
    screened: (&Scene<'_>, &Screen, &NullDistribution),
    progress: &Begin<'_>,
) -> Result<bool, DiscoverError> {
    /// Candidates that may fail as part of the model before the search gives up.
    const FAILURES: usize = 3;
    for _ in 0..FAILURES {
        let current = &outcome.model.current;
        let Some(accepted) = winner(context, current, screened, &history.barred, &mut outcome.refused)?
        else {
            return Ok(false);
        };
        let (candidate, evidence) = (accepted.candidate.clone(), accepted.evidence.clone());
        progress(Progress::Found(candidate.words()))?;
        match admitted(context, &outcome.model, accepted)? {
            Ok(model) => {
                history.barred.clear();
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
