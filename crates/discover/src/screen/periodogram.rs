//! Every period of every joint: the score of a sine and a cosine of its motion, over a fine grid of frequencies.
//!
//! The joint's motion is the same for all periods: it is projected once, and a period costs a product over the visits. Frequencies are as
//! dense as the visited range can tell apart, four to a cycle over it.

use crate::problem::linearisation::Scene;
use crate::problem::projection::{Projection, basis};
use crate::statistics::beta::Share;
use crate::statistics::surprisal::Surprise;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::TAU;
use truepose_kinematics::JointId;

/// The scores of one joint's periods.
pub(crate) struct Periodogram {
    pub joint: JointId,
    pub periods: Vec<f64>,
    pub gains: Vec<f64>,
    pub surprises: Vec<Surprise>,
    /// Of the share that each takes by chance.
    pub laws: Vec<Share>,
    /// Units × 2 columns a period.
    pub by_unit: DMatrix<f32>,
}

/// Finest periods that are looked for: parts of a turn, and of a slide's visited travel.
const CYCLES_PER_TURN: f64 = 256.0;
const CYCLES_PER_TRAVEL: f64 = 400.0;
/// Frequencies handled at once.
const BATCH: usize = 64;

/// Whether the joint's motion is an angle.
pub(crate) fn turns(scene: &Scene<'_>, joint: JointId) -> bool {
    scene.chain().joint(joint).unit() == "rad"
}

/// The grid of periods of one joint, longest first; rad or m.
pub(crate) fn grid(scene: &Scene<'_>, joint: JointId) -> Vec<f64> {
    let Some(range) = scene.travel(joint) else { return Vec::new() };
    if range.is_nan() || range < 1e-6 {
        return Vec::new();
    }
    let turns = turns(scene, joint);
    let (first, last) = if turns { (2.5, CYCLES_PER_TURN) } else { (2.0, CYCLES_PER_TRAVEL) };
    let unit = if turns { TAU } else { range };
    let step = 0.25 * unit / range;
    let first = f64::max(first, unit / range);
    let count = (((last - first) / step).floor().max(-1.0) + 1.0) as usize;
    (0..count).map(|k| unit / (first + k as f64 * step)).collect()
}

/// The scores of these periods of one joint.
pub(crate) fn scan(
    scene: &Scene<'_>,
    projection: &Projection,
    joint: JointId,
    periods: &[f64],
) -> Option<Periodogram> {
    let shares = scene.motion(joint)?;
    let pulses = projection.tables.pulses(&shares);
    let stations = projection.tables.stations.iter();
    let values: Vec<f64> = stations.map(|&at| scene.joint_at(at, joint)).collect::<Option<_>>()?;
    if periods.is_empty() || pulses.square.iter().sum::<f64>() <= 0.0 {
        return None;
    }
    let parts: Vec<(Vec<Wave>, DMatrix<f32>)> = periods
        .par_chunks(BATCH)
        .map(|batch| {
            let mut waves = DMatrix::zeros(values.len(), 2 * batch.len());
            for (k, period) in batch.iter().enumerate() {
                for (at, &value) in values.iter().enumerate() {
                    let (sine, cosine) = (TAU * value / period).sin_cos();
                    waves[(at, 2 * k)] = sine;
                    waves[(at, 2 * k + 1)] = cosine;
                }
            }
            let (along, sums) = pulses.through(&waves, &projection.q_by_unit);
            let mut told = Vec::with_capacity(batch.len());
            let mut by_unit = DMatrix::<f32>::zeros(projection.units, 2 * batch.len());
            for k in 0..batch.len() {
                let raw = pulses.products(&waves.columns(2 * k, 2));
                let pair = along.columns(2 * k, 2);
                let left = &raw - pair.tr_mul(&pair);
                let Some(turn) = basis(&raw, &left) else {
                    told.push(Wave::silent());
                    continue;
                };
                let scores = sums.columns(2 * k, 2) * &turn;
                let squares: f64 = scores.column_iter().map(|c| c.sum().powi(2)).sum();
                let law = projection.law(&scores);
                let gain = projection.gain(squares, projection.rss);
                let surprise = Surprise::of(gain, 2, law.surprise(squares / projection.rss));
                told.push(Wave { gain, surprise, law });
                for (j, column) in scores.column_iter().enumerate() {
                    by_unit.column_mut(2 * k + j).copy_from(&column.map(|v| v as f32));
                }
            }
            (told, by_unit)
        })
        .collect();
    let mut whole = Periodogram {
        joint,
        periods: periods.to_vec(),
        gains: Vec::new(),
        surprises: Vec::new(),
        laws: Vec::new(),
        by_unit: DMatrix::zeros(projection.units, 2 * periods.len()),
    };
    for (told, by_unit) in parts {
        whole.by_unit.columns_mut(2 * whole.gains.len(), by_unit.ncols()).copy_from(&by_unit);
        for wave in told {
            whole.gains.push(wave.gain);
            whole.surprises.push(wave.surprise);
            whole.laws.push(wave.law);
        }
    }
    Some(whole)
}

/// What one period does.
struct Wave {
    gain: f64,
    surprise: Surprise,
    law: Share,
}

impl Wave {
    /// Nothing of it is left beside the present model.
    fn silent() -> Self {
        Wave { gain: 0.0, surprise: Surprise::NONE, law: Share::none() }
    }
}

impl Periodogram {
    /// The period that is most surprising among visits: (period, gain, surprise).
    pub fn strongest(&self) -> Option<(f64, f64, f64)> {
        let surprise = |k: &usize| self.surprises[*k].among_visits;
        let best = (0..self.periods.len()).max_by(|a, b| surprise(a).total_cmp(&surprise(b)))?;
        Some((self.periods[best], self.gains[best], surprise(&best)))
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
