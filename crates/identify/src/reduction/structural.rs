//! The null space that no data can ever fill: over many postures within the limits.
//!
//! Postures follow a Halton sequence (Halton 1960), so that the answer is the same everywhere. What was measured
//! (which components, which targets), loads and channels are taken from the data in turn.

use crate::linearise::dense;
use crate::{IdentifyError, NoiseModel};
use truepose_errormodel::{Dataset, ErrorModel, Interval, Visits};
use truepose_kinematics::{Chain, JointKind};
use truepose_solvers::accumulator::{Factor, Triangular};

/// The range of each movable joint: its limits, or what makes sense where there are none.
pub fn joint_ranges(chain: &Chain, data: Option<&Dataset>) -> Vec<Interval> {
    chain
        .movable()
        .iter()
        .enumerate()
        .map(|(k, &joint)| {
            let described = chain.joint(joint);
            let seen = data.and_then(|data| Interval::of(data.joints[k].iter().copied()));
            match (described.limits, described.kind) {
                (Some((lower, upper)), _) if lower.is_finite() && upper.is_finite() && lower < upper => {
                    Interval { lower, upper }
                }
                (_, JointKind::Prismatic) => {
                    let middle = seen.map_or(0.0, |s| 0.5 * (s.lower + s.upper));
                    let half = seen.map_or(0.5, |s| (s.upper - s.lower).max(0.5));
                    Interval { lower: middle - half, upper: middle + half }
                }
                _ => Interval { lower: -std::f64::consts::PI, upper: std::f64::consts::PI },
            }
        })
        .collect()
}

/// Independent numbers that the postures give for each unknown, and how many postures there are at least.
const NUMBERS: f64 = 1.5;
const POSTURES: usize = 40;

/// Triangular factor of the model, linearised at these coefficients, over postures spread within the limits and seen as `data` was, and
/// over the data itself, whose factor is given.
///
/// # Errors
/// When nothing was measured, or the model does not fit the data.
pub fn spread_factor(
    model: &ErrorModel,
    data: &Dataset,
    own: &Factor,
    coefficients: &[f64],
) -> Result<Factor, IdentifyError> {
    let ranges = joint_ranges(model.chain(), Some(data));
    let measured: Vec<usize> = (0..data.len()).filter(|&row| data.seen(row).count() > 0).collect();
    if measured.is_empty() {
        return Err(IdentifyError::NothingMeasured { rows: data.len() });
    }
    // Along which direction a row of one number would measure elsewhere, and where points would meet, is not known here: those of the data stand
    // for all.
    let elsewhere = |row: &usize| data.ray(*row).is_none() && data.meets(*row).is_none();
    let rows: Vec<usize> = measured.into_iter().filter(elsewhere).collect();
    if rows.is_empty() {
        return Ok(own.clone());
    }
    // Kinds of rows in the order in which they first appear, so that rare targets come up as often as common ones.
    let mut kinds: Vec<usize> = Vec::new();
    for &row in &rows {
        let same =
            |&other: &usize| data.target[other] == data.target[row] && data.seen(other) == data.seen(row);
        if !kinds.iter().any(same) {
            kinds.push(row);
        }
    }
    // However many targets are seen, a posture has no more than the six numbers of a rigid body; the data's own rows come on top.
    let numbers: usize = kinds.iter().map(|&row| data.seen(row).count()).sum();
    let unknowns = model.columns().len() as f64;
    let count = ((NUMBERS * unknowns / numbers.min(6) as f64).ceil() as usize).max(POSTURES);
    let picked: Vec<usize> = (0..count).flat_map(|_| kinds.iter().copied()).collect();
    let conditions: Vec<usize> =
        (0..picked.len()).map(|k| rows[((k / kinds.len()) * 7919) % rows.len()]).collect();
    let mut sample = data.select(&picked);
    let source = data.select(&conditions);
    sample.load = source.load;
    sample.channels = source.channels;
    sample.approach = source.approach;
    sample.time = source.time;
    for (k, range) in ranges.iter().enumerate() {
        for (row, value) in sample.joints[k].iter_mut().enumerate() {
            let posture = row / kinds.len();
            *value =
                range.lower + (range.upper - range.lower) * halton(posture + 1, PRIMES[k % PRIMES.len()]);
        }
    }
    sample.follow(model.chain());
    let length = model.chain().characteristic_length();
    let noise = NoiseModel { position_sd: 1e-3, visit_sd: 0.0, orientation_sd: 1e-3 / length };
    let visits = Visits { rows: (0..sample.len()).map(|row| vec![row]).collect() };
    let rows = dense(model, &sample, &visits, noise, coefficients, None)?;
    // What the data itself shows can be shown: a function with narrow support may be missed by the postures above. Its
    // rows are whitened by other deviations, which moves no null space; they are made as large as those above.
    let (mine, theirs) = (rows.columns(0, own.columns()).norm(), own.r.norm());
    let share = if theirs > 0.0 { mine / theirs } else { 1.0 };
    let own = Factor { r: &own.r * share, z: &own.z * share, ..own.clone() };
    let mut both = Triangular::of(&own);
    both.update_block(rows)?;
    Ok(both.into_factor())
}

const PRIMES: [usize; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];

/// The radical inverse of `index` in a base.
fn halton(mut index: usize, base: usize) -> f64 {
    let (mut value, mut share) = (0.0, 1.0);
    while index > 0 {
        share /= base as f64;
        value += share * (index % base) as f64;
        index /= base;
    }
    value
}
