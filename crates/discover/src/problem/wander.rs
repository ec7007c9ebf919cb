//! The wander of instrument or robot as columns with a prior: the leading cosines of its spectrum, on each axis.
//!
//! ```text
//! w(t) = Σ_k c_k ψ_k(t),   ψ_k = √(2/n) cos(θ_k (t + ½)),   θ_k = πk/n,   var c_k = b (f(θ_k) − f̄),   f = (1 − φ²)/(1 + φ² − 2φ cos θ)
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | t, n | place of a pose on an even grid of steps; length of the grid, with two time constants of margin at both ends | steps |
//! | φ = exp(−1/T) | autocorrelation of the wander over a step | 1 |
//! | f̄ | mean of f over the cosines that are left out: what they make is as good as white, and stays in the white part | 1 |
//!
//! Every step of the search then sees ordinary columns whose prior holds them. Source: Solin and Särkkä (2020), for cosines of a spectrum.

use crate::problem::linearisation::Linearisation;
use crate::problem::sequence::{Process, Sequence};
use nalgebra::{DMatrix, DVector};

/// The wander of a linearised problem.
#[derive(Debug, Clone)]
pub(crate) struct Wander {
    pub sequence: Sequence,
    pub process: Process,
}

impl Process {
    /// Of neighbouring poses.
    pub fn autocorrelation(self) -> f64 {
        self.wander * (-1.0 / self.time).exp() / (self.wander + self.white)
    }
}

/// Most cosines of one axis.
const MOST: usize = 120;
/// Information about a cosine, in inverse variances of its prior, below which it stays in the white part.
const LEAST: f64 = 0.25;

impl Wander {
    /// The problem with the wander's columns, and with the noise that is left.
    pub fn joined<'a>(&self, mut linearisation: Linearisation<'a>) -> Linearisation<'a> {
        let Wander { sequence, process } = self;
        let places = places(sequence, process.time);
        let pad = (2.0 * process.time).ceil();
        let length = places.last().map_or(0.0, |last| last.1) + 1.0 + 2.0 * pad;
        let phi = (-1.0 / process.time).exp();
        let angle = |k: usize| std::f64::consts::PI * k as f64 / length;
        let spectrum: Vec<f64> = (0..length as usize)
            .map(|k| (1.0 - phi * phi) / (1.0 + phi * phi - 2.0 * phi * angle(k).cos()))
            .collect();
        let level =
            |from: usize| spectrum[from..].iter().sum::<f64>() / (spectrum.len() - from).max(1) as f64;
        let information = |k: usize| {
            process.wander * (spectrum[k] - level(k)) / (process.white + process.wander * level(k))
        };
        let count = (0..MOST.min(spectrum.len())).take_while(|&k| information(k) > LEAST).count();
        if count == 0 {
            return linearisation;
        }
        let rest = level(count);
        let (m, r) = linearisation.base.shape();
        let mut columns = DMatrix::zeros(m, 3 * count);
        let mut widths = DVector::zeros(3 * count);
        for (axis, means) in sequence.axes.iter().enumerate() {
            for mean in means {
                let place =
                    places[places.partition_point(|p| p.0 < mean.at).min(places.len() - 1)].1 + pad + 0.5;
                for k in 0..count {
                    let norm = (if k == 0 { 1.0 } else { 2.0 } / length).sqrt();
                    for &(at, _) in &mean.members {
                        columns[(at, axis * count + k)] = norm * (angle(k) * place).cos();
                    }
                }
            }
            for k in 0..count {
                widths[axis * count + k] =
                    (process.wander * sequence.typical * (spectrum[k] - rest)).max(f64::MIN_POSITIVE).sqrt();
            }
        }
        // In their own standard deviations, so that the prior's rows are those of a unit matrix.
        columns.column_iter_mut().zip(widths.iter()).for_each(|(mut column, width)| column *= *width);
        let left = (process.white + process.wander * rest) * sequence.typical;
        linearisation.noise = less_noise(&linearisation, sequence.typical, left).into();
        let more = columns.ncols();
        let mut prior = DMatrix::zeros(r + more, r + more);
        match &linearisation.prior {
            Some(rows) => prior.view_mut((0, 0), rows.shape()).copy_from(rows),
            // Square all the same: rows that hold nothing.
            None => {
                for k in 0..r {
                    prior[(k, k)] = 1e-6 * linearisation.base.column(k).norm() / left.sqrt();
                }
            }
        }
        (r..r + more).for_each(|k| prior[(k, k)] = 1.0);
        linearisation.join_wander(&columns, prior);
        linearisation
    }
}

/// Places of all times on an even grid of steps: gaps over which nothing is remembered are shortened.
fn places(sequence: &Sequence, time: f64) -> Vec<(f64, f64)> {
    let longest = (5.0 * time).max(1.0);
    let mut times: Vec<f64> = sequence.axes.iter().flatten().map(|mean| mean.at).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let (mut place, mut before) = (0.0, times.first().copied().unwrap_or(0.0));
    times
        .into_iter()
        .map(|at| {
            place += (at - before).min(longest);
            before = at;
            (at, place)
        })
        .collect()
}

/// The noise whose typical pose has this variance on an axis, `left`, in place of `typical`.
fn less_noise(linearisation: &Linearisation<'_>, typical: f64, left: f64) -> truepose_identify::NoiseModel {
    let mut noise = linearisation.noise.rows;
    let single = linearisation.visits == linearisation.data.len();
    if noise.visit_sd > 0.0 || (left > typical && !single) {
        noise.visit_sd = (noise.visit_sd.powi(2) + left - typical).max(0.0).sqrt();
    } else if single {
        let least = 1e-2 * noise.position_sd;
        noise.position_sd = (noise.position_sd.powi(2) + left - typical).max(least * least).sqrt();
    }
    noise
}
