//! The best shape of a candidate near where the screen found it: its period, its instant, its threshold.
//!
//! Variable projection: the unknowns are eliminated for each trial shape, the gain is what is left to climb.

use crate::candidate::{Candidate, Change};
use crate::library::{instants, transmission_at};
use crate::periodogram::{longest, turns};
use crate::projection::Projection;
use crate::scene::Scene;
use std::any::Any;
use truepose_errormodel::effects::{Backlash, Drift, LoadNonlinearity, Shift, Thermal, Transmission};
use truepose_errormodel::{AnyEffect, Dataset, NonlinearParameter};

/// What a shape is worth: the gain in the screen's units.
fn gain(scene: &Scene<'_>, projection: &Projection, candidate: &Candidate) -> f64 {
    projection.judge(scene, candidate).map_or(f64::NEG_INFINITY, |score| score.gain)
}

/// The candidate with its shape refined.
pub(crate) fn refined(scene: &Scene<'_>, projection: &Projection, candidate: &Candidate) -> Candidate {
    let [effect] = candidate.effects() else { return candidate.clone() };
    let chain = scene.chain();
    if let Some(wave) = seen_as::<Transmission>(&**effect) {
        let Some(period) = free_period(wave) else { return candidate.clone() };
        let Some(range) = scene.travel(wave.joint) else { return candidate.clone() };
        // In frequency: a quarter of a cycle over the range to either side, but no longer than a drive's periods are.
        let slowest = 1.0 / longest(turns(scene, wave.joint), range);
        let centre = (1.0 / period).max(slowest);
        let half = 0.25 / range.max(1e-9);
        let value =
            |frequency: f64| gain(scene, projection, &transmission_at(chain, wave.joint, &[1.0 / frequency]));
        let best = climb((centre - half).max(slowest), centre + half, value);
        return transmission_at(chain, wave.joint, &[1.0 / best]);
    }
    if let Some(jump) = seen_as::<Shift>(&**effect) {
        let instants = instants(scene.data);
        let at = instants.partition_point(|&t| t < jump.at);
        // The neighbours that the coarse grid left out, and a few more.
        let reach = instants.len().div_ceil(64).max(3) + 2;
        let best = (at.saturating_sub(reach)..(at + reach).min(instants.len()))
            .map(|k| Shift { at: instants[k], ..jump.clone() })
            .map(|jump| Candidate::new(candidate.family, candidate.place.clone(), jump))
            .map(|candidate| (gain(scene, projection, &candidate), candidate))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        return best.map_or_else(|| candidate.clone(), |(_, candidate)| candidate);
    }
    if let Some((value, reach)) = scale(&**effect) {
        let at = |log: f64| {
            let effects = rescaled(&**effect, log.exp(), None).into_iter().collect();
            Candidate { change: Change::Add(effects), ..candidate.clone() }
        };
        let [lower, upper] = reach.map(|times| (times * value).ln());
        return at(climb(lower, upper, |log| gain(scene, projection, &at(log))));
    }
    candidate.clone()
}

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
fn scale(effect: &dyn AnyEffect) -> Option<(f64, [f64; 2])> {
    if let Some(play) = seen_as::<Backlash>(effect) {
        return play.flank_load.map(|load| (load, [0.4, 1.8]));
    }
    if let Some(spring) = seen_as::<LoadNonlinearity>(effect) {
        return spring.soft_load.map(|load| (load, [0.4, 2.5]));
    }
    seen_as::<Drift>(effect)?.time_constant.map(|constant| (constant, [0.4, 2.5]))
}

/// The effect with another such number, known or (with a range) to be found.
fn rescaled(effect: &dyn AnyEffect, value: f64, range: Option<[f64; 2]>) -> Option<Box<dyn AnyEffect>> {
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
fn free_period(wave: &Transmission) -> Option<f64> {
    wave.period.filter(|p| (p - std::f64::consts::TAU).abs() > 1e-9)
}

/// An effect as what it is.
pub(crate) fn seen_as<E: truepose_errormodel::Effect>(effect: &dyn AnyEffect) -> Option<&E> {
    (effect as &dyn Any).downcast_ref()
}

/// Maximum of a function with one peak in [lower, upper], by golden section.
fn climb(lower: f64, upper: f64, value: impl Fn(f64) -> f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut a, mut b) = (lower, upper);
    let (mut c, mut d) = (b - RATIO * (b - a), a + RATIO * (b - a));
    let (mut vc, mut vd) = (value(c), value(d));
    for _ in 0..18 {
        if vc > vd {
            (b, d, vd) = (d, c, vc);
            c = b - RATIO * (b - a);
            vc = value(c);
        } else {
            (a, c, vc) = (c, d, vd);
            d = a + RATIO * (b - a);
            vd = value(d);
        }
    }
    0.5 * (a + b)
}
