//! Parameters in which an effect is not linear: a period, an instant, a time constant, a load.

use crate::hypotheses::candidate::Candidate;
use std::any::Any;
use truepose_errormodel::effects::{Backlash, Drift, LoadNonlinearity, Shift, Thermal, Transmission};
use truepose_errormodel::{AnyEffect, Dataset, NonlinearParameter};

/// How many shapes of a candidate were found rather than known.
pub(crate) fn shapes(candidate: &Candidate) -> usize {
    let one = |effect: &dyn AnyEffect| {
        seen_as::<Transmission>(effect).is_some_and(|wave| free_period(wave).is_some())
            || seen_as::<Shift>(effect).is_some()
            || seen_as::<Thermal>(effect).is_some_and(|growth| growth.lag.is_some())
    };
    candidate.effects().iter().filter(|effect| one(&***effect)).count() + climbed(candidate)
}

/// How many periods of a gear were found rather than known.
pub(crate) fn found_periods(candidate: &Candidate) -> usize {
    let found = |effect: &dyn AnyEffect| {
        seen_as::<Transmission>(effect).is_some_and(|wave| free_period(wave).is_some())
    };
    candidate.effects().iter().filter(|effect| found(&***effect)).count()
}

/// How many of them have a coarse grid, so that they were climbed for.
pub(crate) fn climbed(candidate: &Candidate) -> usize {
    candidate.effects().iter().filter(|effect| scale(&***effect).is_some()).count()
}

/// A positive number in which an effect is not linear and of which the candidates have a coarse grid (a load on a flank, the
/// load of a soft range, a time constant), and between which multiples of it the best is looked for.
pub(crate) fn scale(effect: &dyn AnyEffect) -> Option<(f64, [f64; 2])> {
    if let Some(play) = seen_as::<Backlash>(effect) {
        return play.flank_load.map(|load| (load, [0.4, 1.8]));
    }
    if let Some(spring) = seen_as::<LoadNonlinearity>(effect) {
        return spring.soft_load.map(|load| (load, [0.4, 2.5]));
    }
    seen_as::<Drift>(effect)?.time_constant.map(|constant| (constant, [0.4, 2.5]))
}

/// The effect with another such number, known or (with a range) to be found.
pub(crate) fn rescaled(
    effect: &dyn AnyEffect,
    value: f64,
    range: Option<[f64; 2]>,
) -> Option<Box<dyn AnyEffect>> {
    let value = Some(value);
    if let Some(play) = seen_as::<Backlash>(effect) {
        return Some(Box::new(Backlash { flank_load: value, flank_range: range, ..play.clone() }));
    }
    if let Some(spring) = seen_as::<LoadNonlinearity>(effect) {
        return Some(Box::new(LoadNonlinearity { soft_load: value, soft_range: range, ..spring.clone() }));
    }
    let drift = seen_as::<Drift>(effect)?.clone();
    Some(Box::new(Drift { time_constant: value, time_constant_range: range, ..drift }))
}

/// Whether a candidate of one effect has a shape to refine.
pub(crate) fn has_shape(candidate: &Candidate) -> bool {
    let [effect] = candidate.effects() else { return false };
    let effect = &**effect;
    seen_as::<Transmission>(effect).is_some_and(|wave| free_period(wave).is_some())
        || seen_as::<Shift>(effect).is_some()
        || scale(effect).is_some()
}

/// What was found of an effect's shape, within the range in which its interval is looked for.
pub(crate) fn found(effect: &dyn AnyEffect, data: &Dataset) -> Vec<NonlinearParameter> {
    /// Times, up and down.
    const REACH: f64 = 4.0;
    let around = |value: f64| Some([value / REACH, value * REACH]);
    if let Some(wave) = seen_as::<Transmission>(effect) {
        let range = free_period(wave).and_then(around);
        return AnyEffect::shape(&Transmission { period_range: range, ..wave.clone() });
    }
    if let Some(jump) = seen_as::<Shift>(effect) {
        let ends =
            data.time.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &t| [a.min(t), b.max(t)]);
        return AnyEffect::shape(&Shift { at_range: Some(ends), ..jump.clone() });
    }
    if let Some(growth) = seen_as::<Thermal>(effect) {
        return AnyEffect::shape(&Thermal { lag_range: growth.lag.and_then(around), ..growth.clone() });
    }
    let released = |(value, _)| rescaled(effect, value, around(value));
    scale(effect).and_then(released).map_or_else(Vec::new, |effect| effect.shape())
}

/// A period that is not known; a turn of the joint is.
pub(crate) fn free_period(wave: &Transmission) -> Option<f64> {
    wave.period.filter(|p| (p - std::f64::consts::TAU).abs() > 1e-9)
}

/// An effect as what it is.
pub(crate) fn seen_as<E: truepose_errormodel::Effect>(effect: &dyn AnyEffect) -> Option<&E> {
    (effect as &dyn Any).downcast_ref()
}
