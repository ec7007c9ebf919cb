//! Every period of every joint: the score of a sine and a cosine of its motion, over a fine grid of frequencies.
//!
//! The joint's motion is the same for all periods: it is projected once, and a period costs a product over the visits. Frequencies are as
//! dense as the visited range can tell apart, four to a cycle over it.

use crate::problem::linearisation::Linearisation;
use crate::problem::projection::{Projection, basis};
use crate::statistics::beta::FractionDistribution;
use crate::statistics::surprisal::Surprisal;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::TAU;
use truepose_kinematics::JointId;

/// The scores of one joint's periods.
pub(crate) struct Periodogram {
    pub joint: JointId,
    pub periods: Vec<f64>,
    pub gains: Vec<f64>,
    pub surprisals: Vec<Surprisal>,
    /// Of the share that each takes by chance.
    pub distributions: Vec<FractionDistribution>,
    /// Units × 2 columns a period.
    pub by_unit: DMatrix<f32>,
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
    (0..count).map(|k| unit / (first + k as f64 * step)).collect()
}

/// The scores of these periods of one joint.
pub(crate) fn scan(
    linearisation: &Linearisation<'_>,
    projection: &Projection,
    joint: JointId,
    periods: &[f64],
) -> Option<Periodogram> {
    let shares = linearisation.motion(joint)?;
    let response = projection.tables.unit_response(&shares);
    let stations = projection.tables.stations.iter();
    let values: Vec<f64> = stations.map(|&at| linearisation.joint_at(at, joint)).collect::<Option<_>>()?;
    if periods.is_empty() || response.square.iter().sum::<f64>() <= 0.0 {
        return None;
    }
    let parts: Vec<(Vec<PeriodScore>, DMatrix<f32>)> = periods
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
            let (along, sums) = response.through(&waves, &projection.q_by_unit);
            let mut told = Vec::with_capacity(batch.len());
            let mut by_unit = DMatrix::<f32>::zeros(projection.units, 2 * batch.len());
            for k in 0..batch.len() {
                let raw = response.products(&waves.columns(2 * k, 2));
                let pair = along.columns(2 * k, 2);
                let left = &raw - pair.tr_mul(&pair);
                let Some(turn) = basis(&raw, &left, projection.absorbed) else {
                    told.push(PeriodScore::absorbed());
                    continue;
                };
                let scores = sums.columns(2 * k, 2) * &turn;
                let squares: f64 = scores.column_iter().map(|c| c.sum().powi(2)).sum();
                let distribution = projection.fraction_distribution(&scores);
                let gain = projection.gain(squares, projection.rss);
                let surprisal = Surprisal::of(gain, 2, distribution.surprisal(squares / projection.rss));
                told.push(PeriodScore { gain, surprisal, distribution });
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
        surprisals: Vec::new(),
        distributions: Vec::new(),
        by_unit: DMatrix::zeros(projection.units, 2 * periods.len()),
    };
    for (told, by_unit) in parts {
        whole.by_unit.columns_mut(2 * whole.gains.len(), by_unit.ncols()).copy_from(&by_unit);
        for wave in told {
            whole.gains.push(wave.gain);
            whole.surprisals.push(wave.surprisal);
            whole.distributions.push(wave.distribution);
        }
    }
    Some(whole)
}

/// What one period does.
struct PeriodScore {
    gain: f64,
    surprisal: Surprisal,
    distribution: FractionDistribution,
}

impl PeriodScore {
    /// Nothing of it is left beside the present model.
    fn absorbed() -> Self {
        PeriodScore { gain: 0.0, surprisal: Surprisal::NONE, distribution: FractionDistribution::none() }
    }
}

impl Periodogram {
    /// The period that is most surprising among visits: (period, gain, surprise).
    pub fn strongest(&self) -> Option<(f64, f64, f64)> {
        let surprisal = |k: &usize| self.surprisals[*k].among_poses;
        let best = (0..self.periods.len()).max_by(|a, b| surprisal(a).total_cmp(&surprisal(b)))?;
        Some((self.periods[best], self.gains[best], surprisal(&best)))
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
