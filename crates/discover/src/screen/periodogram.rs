//! Every period of every joint: the score of a sine and a cosine of its motion, over a fine grid of frequencies.
//!
//! The joint's motion is the same for all periods: it is projected once, and a period costs a product over the visits. Frequencies are as
//! dense as the visited range can tell apart, four to a cycle over it.

use crate::hypotheses::levels::Levels;
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::{Projection, Score};
use crate::significance::rotation::{Largest, Rotations};
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::TAU;
use truepose_kinematics::JointId;

/// The scores of one joint's periods.
pub(crate) struct Periodogram {
    pub joint: JointId,
    pub periods: Vec<f64>,
    pub gains: Vec<f64>,
    /// −ln p of each, as a single test.
    pub surprisals: Vec<f64>,
    /// Bases of the projected columns.
    bases: Vec<Option<DMatrix<f32>>>,
    /// The sites of the joint's motion with their shares, and its values.
    shares: Vec<(usize, f64)>,
    values: Vec<f64>,
}

/// Frequencies handled at once.
const BATCH: usize = 64;

/// Whether the joint's motion is an angle.
pub(crate) fn turns(linearisation: &Linearisation<'_>, joint: JointId) -> bool {
    linearisation.chain().joint(joint).unit() == "rad"
}

/// The grid of periods of one joint, longest first; rad or m.
pub(crate) fn grid(linearisation: &Linearisation<'_>, joint: JointId) -> Vec<f64> {
    let Some(range) = linearisation.travel(joint) else { return Vec::new() };
    if range.is_nan() || range < 1e-6 {
        return Vec::new();
    }
    let policy = linearisation.policy;
    let turns = turns(linearisation, joint);
    let (first, last) = if turns { (2.5, policy.cycles_per_turn) } else { (2.0, policy.cycles_per_travel) };
    let unit = if turns { TAU } else { range };
    let step = policy.frequency_step * unit / range;
    let first = f64::max(first, unit / range);
    let count = (((last - first) / step).floor().max(-1.0) + 1.0) as usize;
    let shortest = Levels::of(linearisation.chain(), linearisation.data, joint).shortest_period();
    (0..count).map(|k| unit / (first + k as f64 * step)).filter(|period| *period >= shortest).collect()
}

/// The scores of these periods of one joint.
pub(crate) fn scan(
    linearisation: &Linearisation<'_>,
    projection: &Projection,
    joint: JointId,
    periods: &[f64],
) -> Option<Periodogram> {
    let shares = linearisation.motion(joint)?;
    let response = projection.tables(linearisation).unit_response(&projection.q, &shares);
    let stations = projection.tables(linearisation).stations.iter();
    let values: Vec<f64> = stations.map(|&at| linearisation.joint_at(at, joint)).collect::<Option<_>>()?;
    if periods.is_empty() || response.square.iter().sum::<f64>() <= 0.0 {
        return None;
    }
    let scores: Vec<Option<Score>> = periods
        .par_chunks(BATCH)
        .flat_map_iter(|batch| {
            let waves = waves(&values, batch);
            let (along, scores) = response.through(&waves);
            let judged = |k: usize| {
                let raw = response.of_wave(&waves.columns(2 * k, 2));
                projection.judged(&raw, &along.columns(2 * k, 2), &scores.rows(2 * k, 2).into_owned())
            };
            (0..batch.len()).map(judged).collect::<Vec<_>>()
        })
        .collect();
    let mut whole = Periodogram {
        joint,
        periods: periods.to_vec(),
        gains: Vec::new(),
        surprisals: Vec::new(),
        bases: Vec::new(),
        shares,
        values,
    };
    for score in scores {
        // Of an absorbed period nothing is left beside the present model.
        whole.gains.push(score.as_ref().map_or(0.0, |score| score.gain));
        whole.surprisals.push(score.as_ref().map_or(0.0, |score| score.surprisal));
        whole.bases.push(score.map(|score| score.basis));
    }
    Some(whole)
}

/// Sine and cosine of each period, visits × 2 periods. Where frequencies are evenly spaced each angle is the one before turned by a step.
fn waves(values: &[f64], periods: &[f64]) -> DMatrix<f64> {
    /// Turns by which a frequency may miss the even spacing.
    const EVEN: f64 = 1e-12;
    let frequency = |k: usize| 1.0 / periods[k];
    let step = if periods.len() > 1 { frequency(1) - frequency(0) } else { 0.0 };
    let even = |k: usize| (frequency(k) - frequency(0) - k as f64 * step).abs() <= EVEN * frequency(k);
    let mut waves = DMatrix::zeros(values.len(), 2 * periods.len());
    if periods.is_empty() || !(0..periods.len()).all(even) {
        for (k, period) in periods.iter().enumerate() {
            for (at, &value) in values.iter().enumerate() {
                (waves[(at, 2 * k)], waves[(at, 2 * k + 1)]) = (TAU * value / period).sin_cos();
            }
        }
        return waves;
    }
    let angles = |frequency: f64| values.iter().map(move |value| (TAU * value * frequency).sin_cos());
    let mut now: Vec<(f64, f64)> = angles(frequency(0)).collect();
    let turns: Vec<(f64, f64)> = angles(step).collect();
    for pair in waves.column_iter_mut().collect::<Vec<_>>().chunks_exact_mut(2) {
        let [sines, cosines] = pair else { continue };
        for (at, ((sine, cosine), (sine_step, cosine_step))) in now.iter_mut().zip(&turns).enumerate() {
            (sines[at], cosines[at]) = (*sine, *cosine);
            (*sine, *cosine) =
                (*sine * cosine_step + *cosine * sine_step, *cosine * cosine_step - *sine * sine_step);
        }
    }
    waves
}

impl Periodogram {
    /// The sites of the joint's motion, with their shares.
    pub fn shares(&self) -> &[(usize, f64)] {
        &self.shares
    }

    /// Gains and surprisals of every period from its basis, by other rows.
    pub fn rejudge(&mut self, judged: impl Fn(usize, &DMatrix<f32>) -> (f64, f64)) {
        for (k, basis) in self.bases.iter().enumerate() {
            if let Some(basis) = basis {
                (self.gains[k], self.surprisals[k]) = judged(k, basis);
            }
        }
    }

    /// The period with the smallest p: (period, gain, surprisal).
    pub fn strongest(&self) -> Option<(f64, f64, f64)> {
        let surprisal = |k: &usize| self.surprisals[*k];
        let best = (0..self.periods.len()).max_by(|a, b| surprisal(a).total_cmp(&surprisal(b)))?;
        Some((self.periods[best], self.gains[best], surprisal(&best)))
    }

    /// The largest explained fractions under random rotations.
    pub fn largest(&self, rotations: &Rotations, at: &[DMatrix<f32>]) -> Largest {
        let mut motion = DMatrix::<f32>::zeros(self.values.len(), rotations.directions.ncols());
        self.shares.iter().for_each(|&(site, share)| motion += &at[site] * share as f32);
        let chunks: Vec<usize> = (0..self.periods.len()).step_by(BATCH).collect();
        chunks
            .into_par_iter()
            .map(|first| {
                let last = (first + BATCH).min(self.periods.len());
                let waves = waves(&self.values, &self.periods[first..last]).map(|v| v as f32);
                let scores = waves.transpose() * &motion;
                let mut largest = rotations.nothing();
                for k in first..last {
                    if let Some(basis) = &self.bases[k] {
                        rotations.add(&mut largest, &scores.rows(2 * (k - first), 2), basis);
                    }
                }
                largest
            })
            .reduce(|| rotations.nothing(), Largest::with)
    }

    /// Local maxima, best first: (period, gain).
    pub fn peaks(&self, count: usize) -> Vec<(f64, f64)> {
        let mut peaks: Vec<(f64, f64)> = (0..self.gains.len())
            .filter(|&k| {
                (k == 0 || self.gains[k] >= self.gains[k - 1])
                    && (k + 1 == self.gains.len() || self.gains[k] > self.gains[k + 1])
            })
            .map(|k| (self.periods[k], self.gains[k]))
            .collect();
        peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
        peaks.truncate(count);
        peaks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_are_sines_and_cosines_of_any_periods() {
        let values: Vec<f64> = (0..40).map(|k| 0.17 * f64::from(k) - 3.0).collect();
        let even: Vec<f64> = (0..64).map(|k| TAU / (200.0 + 0.25 * f64::from(k))).collect();
        let uneven = [0.5, 0.3, 0.29];
        for periods in [&even[..], &uneven, &even[..1], &[]] {
            let waves = waves(&values, periods);
            assert_eq!(waves.shape(), (40, 2 * periods.len()));
            for (k, period) in periods.iter().enumerate() {
                for (at, value) in values.iter().enumerate() {
                    let (sine, cosine) = (TAU * value / period).sin_cos();
                    assert!((waves[(at, 2 * k)] - sine).abs() < 1e-11);
                    assert!((waves[(at, 2 * k + 1)] - cosine).abs() < 1e-11);
                }
            }
        }
    }
}
