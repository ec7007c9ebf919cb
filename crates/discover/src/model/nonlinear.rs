//! The shapes of all finds together.
//!
//! A period, an instant or a time constant was found while causes that came later were not yet in the model. With all of them in, the
//! shapes go down together to the bottom of the valley in which they lie (variable projection, [`truepose_identify::descend_nonlinear`]).

use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, Change};
use crate::hypotheses::nonlinear::seen_as;
use crate::model::current::Ground;
use truepose_errormodel::effects::{Shift, Thermal};
use truepose_errormodel::{AnyEffect, Dataset, NonlinearParameter};
use truepose_identify::{Fit, descend_nonlinear};

/// With more shapes than this they stay where the search found them: going down together would take minutes.
const MOST: usize = 24;

/// (Effect of the model, parameter at its value with the range in which it is looked for) of every find.
pub(crate) fn shapes(
    ground: &Ground<'_>,
    found: &[Candidate],
    data: &Dataset,
) -> Vec<(usize, NonlinearParameter)> {
    (0..found.len())
        .flat_map(|k| ground.effects_of(found, k).zip(found[k].effects()))
        .flat_map(|(k, effect)| {
            crate::hypotheses::nonlinear::found(&**effect, data).into_iter().map(move |shape| (k, shape))
        })
        .collect()
}

/// The finds with their shapes where all of them together explain most; none when there is none to move. A lag stays where it is: the
/// data has the history of a channel for the lags of a grid.
pub(crate) fn descended(
    ground: &Ground<'_>,
    found: &[Candidate],
    fit: &Fit,
    data: &Dataset,
) -> Result<Option<Vec<Candidate>>, DiscoverError> {
    let lags = |effect: &dyn AnyEffect| seen_as::<Thermal>(effect).is_some();
    let effects: Vec<Box<dyn AnyEffect>> = found.iter().flat_map(|c| c.effects().to_vec()).collect();
    let first = ground.declared.len();
    let mut free = shapes(ground, found, data);
    free.retain(|(k, _)| !lags(&*effects[k - first]));
    if free.is_empty() || free.len() > MOST {
        return Ok(None);
    }
    // Shapes that the data cannot tell from others stay.
    let Ok(values) = descend_nonlinear(fit, data, &free) else { return Ok(None) };
    if free.iter().zip(&values).all(|((_, shape), value)| (value - shape.value).abs() <= 0.0) {
        return Ok(None);
    }
    let mut next = found.to_vec();
    for (k, candidate) in next.iter_mut().enumerate() {
        let Change::Add(effects) = &mut candidate.change else { continue };
        for (at, effect) in ground.effects_of(found, k).zip(effects) {
            let own: Vec<f64> =
                free.iter().zip(&values).filter(|((e, _), _)| *e == at).map(|(_, v)| *v).collect();
            if !own.is_empty() {
                *effect = effect.with_nonlinear(&own);
            }
        }
    }
    Ok(Some(next))
}

/// The finds with what the data says of when something jumped: between which rows, and in the middle of them.
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

/// Between which instants the jumps of a find are known to lie, s.
pub(crate) fn gaps(found: &Candidate) -> Vec<[f64; 2]> {
    found.effects().iter().filter_map(|effect| seen_as::<Shift>(&**effect)?.gap).collect()
}
