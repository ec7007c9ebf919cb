//! Joint optimisation of the nonlinear parameters of all findings.
//!
//! A period, change point or time constant was estimated before later findings were in the model. With all of
//! them in it, the nonlinear parameters are optimised jointly, to the local minimum next to their values
//! (variable projection, [`truepose_identify::descend_nonlinear`]).

use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement};
use crate::model::current::Context;
use truepose_errormodel::{Dataset, NonlinearParameter};
use truepose_identify::{Fit, descend_nonlinear};

/// (index of the effect in the model, parameter with its value and search range) of every finding.
pub(crate) fn nonlinear_parameters(
    context: &Context<'_>,
    found: &[Candidate],
    data: &Dataset,
) -> Vec<(usize, NonlinearParameter)> {
    let of = |(which, candidate): (usize, &Candidate)| -> Vec<(usize, NonlinearParameter)> {
        let effects = context.effects_of(found, which).zip(candidate.effects());
        effects
            .flat_map(|(k, effect)| {
                candidate.shapes_of(&**effect, data).into_iter().map(move |shape| (k, shape))
            })
            .collect()
    };
    found.iter().enumerate().flat_map(of).collect()
}

/// The findings at the joint optimum of their nonlinear parameters; `None` when none can move. A first-order
/// lag keeps its value: the data has lagged channels for a grid of time constants.
pub(crate) fn descended(
    context: &Context<'_>,
    found: &[Candidate],
    fit: &Fit,
    data: &Dataset,
) -> Result<Option<Vec<Candidate>>, DiscoverError> {
    let on_a_grid: Vec<bool> = found
        .iter()
        .flat_map(|c| c.effects().iter().map(|effect| c.hypothesis().nonlinear(&**effect)))
        .map(|found| found.is_some_and(|found| found.search == Refinement::Grid))
        .collect();
    let first = context.declared.len();
    let mut free = nonlinear_parameters(context, found, data);
    free.retain(|(k, _)| !on_a_grid[k - first]);
    if free.is_empty() || free.len() > context.budget().joint_parameters {
        return Ok(None);
    }
    // Nonlinear parameters that are not identifiable keep their values.
    let Ok(values) = descend_nonlinear(fit, data, &free) else { return Ok(None) };
    if free.iter().zip(&values).all(|((_, shape), value)| (value - shape.value).abs() <= 0.0) {
        return Ok(None);
    }
    let mut next = found.to_vec();
    for (k, candidate) in next.iter_mut().enumerate() {
        let Change::Add(effects) = &mut candidate.change else { continue };
        for (at, effect) in context.effects_of(found, k).zip(effects) {
            let own: Vec<f64> =
                free.iter().zip(&values).filter(|((e, _), _)| *e == at).map(|(_, v)| *v).collect();
            if !own.is_empty() {
                *effect = effect.with_nonlinear(&own);
            }
        }
    }
    Ok(Some(next))
}

/// The findings with each change point in the middle of the gap between the rows before and after it, and
/// with that gap.
pub(crate) fn between_rows(found: &[Candidate], data: &Dataset) -> Vec<Candidate> {
    let mut next = found.to_vec();
    for (candidate, before) in next.iter_mut().zip(found) {
        let hypothesis = before.hypothesis();
        let Change::Add(effects) = &mut candidate.change else { continue };
        for effect in effects {
            let Some(Nonlinear { value: at, search: Refinement::Instant { .. }, .. }) =
                hypothesis.nonlinear(&**effect)
            else {
                continue;
            };
            let times = || data.time.iter().copied();
            let before = times().filter(|t| *t < at).fold(f64::NEG_INFINITY, f64::max);
            let after = times().filter(|t| *t >= at).fold(f64::INFINITY, f64::min);
            if before.is_finite()
                && after.is_finite()
                && before < after
                && let Some(placed) = hypothesis.between(&**effect, [before, after])
            {
                *effect = placed;
            }
        }
    }
    next
}

/// The gaps (start, end) in which the change points of a finding lie, s.
pub(crate) fn gaps(found: &Candidate) -> Vec<[f64; 2]> {
    found
        .nonlinear()
        .filter_map(|found| match found.search {
            Refinement::Instant { gap } => gap,
            _ => None,
        })
        .collect()
}
