//! The best shape of a candidate near where the screen found it: its period, its instant, its threshold.
//!
//! Variable projection: the unknowns are eliminated for each trial shape, the gain is what is left to climb.

use crate::data::payload::is_part;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement};
use crate::hypotheses::time::instants;
use crate::hypotheses::transmission::longest;
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::Projection;
use crate::screen::periodogram::turns;
use truepose_kinematics::JointId;

/// What a shape is worth: the gain in the screen's units.
fn gain(linearisation: &Linearisation<'_>, projection: &Projection, candidate: &Candidate) -> f64 {
    projection.judge(linearisation, candidate).map_or(f64::NEG_INFINITY, |score| score.gain)
}

/// The candidate with its nonlinear parameter refined; the candidate itself where it has none, or the data leaves nothing to refine.
pub(crate) fn refined(
    linearisation: &Linearisation<'_>,
    projection: &Projection,
    candidate: &Candidate,
) -> Candidate {
    better(linearisation, projection, candidate).unwrap_or_else(|| candidate.clone())
}

fn better(
    linearisation: &Linearisation<'_>,
    projection: &Projection,
    candidate: &Candidate,
) -> Option<Candidate> {
    if let Change::CorrectLoad { level, during: Some(during), .. } = candidate.change {
        return Some(stretch(linearisation, projection, candidate, (level, during)));
    }
    let [_] = candidate.effects() else { return None };
    let [_, second] = candidate.pair();
    if second.is_none() {
        return one(linearisation, projection, candidate, false);
    }
    // Each in turn, with the other one as it was found.
    let mut now = candidate.clone();
    for k in 0..SWEEPS {
        now = one(linearisation, projection, &now, k % 2 == 0).unwrap_or(now);
    }
    Some(now)
}

/// Passes over two nonlinear parameters, the second one first.
const SWEEPS: usize = 4;

/// The candidate with one of its nonlinear parameters, the second or the first, at its best value nearby.
fn one(
    linearisation: &Linearisation<'_>,
    projection: &Projection,
    candidate: &Candidate,
    second: bool,
) -> Option<Candidate> {
    let Nonlinear { value, search } = candidate.pair()[usize::from(second)]?;
    let at = |value: f64| if second { candidate.with_second(value) } else { candidate.with_value(value) };
    let gain =
        |value: f64| at(value).map_or(f64::NEG_INFINITY, |other| gain(linearisation, projection, &other));
    match search {
        Refinement::Period(joint) => {
            let range = linearisation.travel(joint)?;
            // In frequency: a quarter of a cycle over the range to either side, but no longer than a drive's periods are.
            let slowest = 1.0 / longest(turns(linearisation, joint), range);
            let centre = (1.0 / value).max(slowest);
            let half = 0.25 / range.max(1e-9);
            let best = climb((centre - half).max(slowest), centre + half, |frequency| gain(1.0 / frequency));
            at(1.0 / best)
        }
        Refinement::Instant { .. } => at(nearest_best(&instants(linearisation.data), value, gain)?),
        Refinement::Edge(joint) => at(nearest_best(&edges(linearisation, joint), value, gain)?),
        Refinement::Scale(multiples) => {
            let [lower, upper] = multiples.map(|times| (times * value).ln());
            at(climb(lower, upper, |log| gain(log.exp())).exp())
        }
        Refinement::Plateau(multiples) => at(middle_of_best(multiples.map(|times| times * value), gain)),
        Refinement::Within([lower, upper]) => at(climb(lower, upper, gain)),
        Refinement::Grid => None,
    }
}

/// A payload that is wrong in a stretch of time, with its ends between the best pose measurements nearby.
fn stretch(
    linearisation: &Linearisation<'_>,
    projection: &Projection,
    candidate: &Candidate,
    (level, [mut from, mut until]): (f64, [f64; 2]),
) -> Candidate {
    let with = |ends: [f64; 2]| {
        let mut other = candidate.clone();
        if let Change::CorrectLoad { during, .. } = &mut other.change {
            *during = Some(ends);
        }
        other
    };
    // As far as a quarter of the record is from the next one.
    let instants = instants(linearisation.data);
    let near = |value: f64| {
        let first = instants.partition_point(|&t| t < value);
        let reach = instants.len() / 4;
        instants[first.saturating_sub(reach)..(first + reach).min(instants.len())].iter().copied()
    };
    for _ in 0..2 {
        // All of them are no stretch but another hypothesis.
        let gain = |ends: [f64; 2]| match is_part(linearisation.data, level, ends) {
            true => gain(linearisation, projection, &with(ends)),
            false => f64::NEG_INFINITY,
        };
        let ends = near(until).filter(|&t| t > from).chain([until]).map(|t| (gain([from, t]), t));
        until = ends.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(until, |best| best.1);
        let begins = near(from).filter(|&t| t < until).chain([from]).map(|t| (gain([t, until]), t));
        from = begins.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(from, |best| best.1);
    }
    with([from, until])
}

/// The middle, over the logarithm, of the stretch with the best value of a function with steps.
fn middle_of_best([lower, upper]: [f64; 2], gain: impl Fn(f64) -> f64) -> f64 {
    const STEPS: i32 = 32;
    let at = |k: i32| lower * (upper / lower).powf(f64::from(k) / f64::from(STEPS));
    let gains: Vec<f64> = (0..=STEPS).map(|k| gain(at(k))).collect();
    let best = gains.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let same = |k: &i32| gains[*k as usize] >= best - 1e-9 * best.abs();
    let first = (0..=STEPS).find(same).unwrap_or(0);
    let last = (first..=STEPS).take_while(same).last().unwrap_or(first);
    (at(first) * at(last)).sqrt()
}

/// The best of the places near a value: the neighbours that the coarse grid left out, and a few more.
fn nearest_best(places: &[f64], value: f64, gain: impl Fn(f64) -> f64) -> Option<f64> {
    let first = places.partition_point(|&place| place < value);
    let reach = places.len().div_ceil(64).max(3) + 2;
    let near = first.saturating_sub(reach)..(first + reach).min(places.len());
    places[near].iter().map(|&t| (gain(t), t)).max_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
}

/// Places between neighbouring visited values of a joint, rad or m.
fn edges(linearisation: &Linearisation<'_>, joint: JointId) -> Vec<f64> {
    let Some(column) = linearisation.chain().coordinate(joint) else { return Vec::new() };
    let mut values = linearisation.data.joints[column].clone();
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    values.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
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
