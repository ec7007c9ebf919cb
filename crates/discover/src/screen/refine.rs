//! The best shape of a candidate near where the screen found it: its period, its instant, its threshold.
//!
//! Variable projection: the unknowns are eliminated for each trial shape, the gain is what is left to climb.

use crate::hypotheses::candidate::{Candidate, Change};
use crate::hypotheses::motion::{longest, transmission_at};
use crate::hypotheses::nonlinear::{free_period, rescaled, scale, seen_as};
use crate::hypotheses::time::instants;
use crate::problem::linearisation::Scene;
use crate::problem::projection::Projection;
use crate::screen::periodogram::turns;
use truepose_errormodel::effects::{Shift, Transmission};

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
