//! Joint optimisation of the nonlinear parameters of all findings.
//!
//! A period, change point or time constant was estimated before later findings were in the model. With all of
//! them in it, the nonlinear parameters are optimised jointly, to the local minimum next to their values
//! (variable projection, [`truepose_identify::descend_nonlinear`]).

use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, Change};
use crate::hypotheses::nonlinear::seen_as;
use crate::model::current::Context;
use truepose_errormodel::effects::{Shift, Thermal};
use truepose_errormodel::{AnyEffect, Dataset, NonlinearParameter};
use truepose_identify::{Fit, descend_nonlinear};

/// (Effect of the model, parameter at its value with the range in which it is looked for) of every find.
pub(crate) fn nonlinear_parameters(
    context: &Context<'_>,
    found: &[Candidate],
    data: &Dataset,
) -> Vec<(usize, NonlinearParameter)> {
    (0..found.len())
        .flat_map(|k| context.effects_of(found, k).zip(found[k].effects()))
        .flat_map(|(k, effect)| {
            crate::hypotheses::nonlinear::found(&**effect, data).into_iter().map(move |shape| (k, shape))
        })
        .collect()
}

/// The findings at the joint optimum of their nonlinear parameters; `None` when none can move. A first-order
/// lag keeps its value: the data has lagged channels for a grid of time constants.
pub(crate) fn descended(
    context: &Context<'_>,
    found: &[Candidate],
    fit: &Fit,
    data: &Dataset,
) -> Result<Option<Vec<Candidate>>, DiscoverError> {
    let lags = |effect: &dyn AnyEffect| seen_as::<Thermal>(effect).is_some();
    let effects: Vec<Box<dyn AnyEffect>> = found.iter().flat_map(|c| c.effects().to_vec()).collect();
    let first = context.declared.len();
    let mut free = nonlinear_parameters(context, found, data);
    free.retain(|(k, _)| !lags(&*effects[k - first]));
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
    for candidate in &mut next {
        let Change::Add(effects) = &mut candidate.change else { continue };
        for effect in effects {
            let Some(jump) = seen_as::<Shift>(&**effect) else { continue };
            let times = || data.time.iter().copied();
            let before = times().filter(|t| *t < jump.at).fold(f64::NEG_INFINITY, f64::max);
            let after = times().filter(|t| *t >= jump.at).fold(f64::INFINITY, f64::min);
            if before.is_finite() && after.is_finite() && before < after {
                let middle = 0.5 * (before + after);
                *effect = Box::new(Shift { at: middle, gap: Some([before, after]), ..jump.clone() });
            }
        }
    }
    next
}

/// The gaps (start, end) in which the change points of a finding lie, s.
pub(crate) fn gaps(found: &Candidate) -> Vec<[f64; 2]> {
    found.effects().iter().filter_map(|effect| seen_as::<Shift>(&**effect)?.gap).collect()
}
