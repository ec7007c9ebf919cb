//! Score test of poses that do not depend on those measured shortly before.
//!
//! ```text
//! U_T = Σ_v Σ_{w≠v} e_v e_w exp(−|t_v − t_w|/T) / Σ e²,     e = whitened means of the poses' residuals,     T = 1, 3, 9 … steps
//! S   = max over T of (U_T − E U_T) / sd U_T
//! ```
//!
//! U_T is the score of the variance of a Matérn ½ process with that time constant, a weighted sum of autocorrelations of all lags
//! (Ljung–Box weighs them alike). The model absorbs part of what is slow, so that residuals of independent poses are no white noise: E and sd are
//! those of projected noise, and p is the fraction of 999 projected normal vectors whose S is as large.
//!
//! Sources: Ljung and Box (1978); Lin (1997) for score tests of variance components.

use crate::problem::sequence::{Mean, Sequence};
use crate::statistics::product::{cross, gram_matrix, orthonormal};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::ops::Range;

/// Normal vectors of the test.
const DRAWS: usize = 999;
/// How many of them a thread has in memory.
const AT_ONCE: usize = 32;
/// Standard deviations of S below which no vectors are drawn.
const CLOSE: f64 = 1.5;

/// What the test says.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Autocorrelation {
    pub p_value: f64,
    /// Of neighbouring poses, by moments.
    pub neighbours: f64,
    /// Time constant of the largest score, in steps.
    pub time: f64,
    pub timed: bool,
}

/// Tests whitened [A | y].
pub(crate) fn autocorrelation(
    sequence: &Sequence,
    white: &DMatrix<f64>,
    prior: Option<&DMatrix<f64>>,
    seed: u64,
) -> Autocorrelation {
    let (m, r) = (white.nrows(), white.ncols() - 1);
    let below = prior.map_or(0, DMatrix::nrows);
    let mut joined = white.columns(0, r).into_owned().resize_vertically(m + below, 0.0);
    if let Some(prior) = prior {
        joined.rows_mut(m, below).copy_from(prior);
    }
    let top = orthonormal(joined).rows(0, m).into_owned();
    let y = white.column(r);
    let residual = y - &top * top.tr_mul(&y);
    let mut times = vec![1.0];
    while times[times.len() - 1] * 3.0 < 0.3 * sequence.span {
        times.push(times[times.len() - 1] * 3.0);
    }
    let basis = stacked(&sequence.means(&top));
    drop(top);
    let own = stacked(&sequence.means(&DMatrix::from_column_slice(m, 1, residual.as_slice())));
    let statistic = Statistic::new(sequence, &times, &basis);
    let (largest, at) = statistic.of(own.as_slice());
    let p_value = if largest < CLOSE {
        (times.len() as f64 * normal_tail(largest)).clamp(0.0, 1.0)
    } else {
        // What noise does to the model is what its means do, and what it has beside them.
        let beside = root(&(DMatrix::identity(r, r) - gram_matrix(&basis)));
        let above = |first: usize| -> usize {
            let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x7d11_c0de);
            random.set_stream(first as u64);
            let count = AT_ONCE.min(DRAWS - first);
            let mut noise = DMatrix::from_fn(basis.nrows(), count, |_, _| gaussian(&mut random));
            let further = DMatrix::from_fn(r, count, |_, _| gaussian(&mut random));
            let along = cross(&basis, &noise) + &beside * further;
            noise.gemm(-1.0, &basis, &along, 1.0);
            noise.column_iter().filter(|drawn| statistic.of(drawn.as_slice()).0 >= largest).count()
        };
        let above: usize = (0..DRAWS).step_by(AT_ONCE).par_bridge().map(above).sum();
        (1.0 + above as f64) / (1.0 + DRAWS as f64)
    };
    // Of neighbours alone: what is expected of independent poses is taken off.
    let (mut next, mut expected) = (0.0, 0.0);
    for axis in &statistic.axes {
        for k in axis.start + 1..axis.end {
            next += own[k] * own[k - 1];
            expected -= basis.row(k).dot(&basis.row(k - 1));
        }
    }
    let neighbours = next / own.norm_squared().max(f64::MIN_POSITIVE) - expected / statistic.freedom.max(1.0);
    Autocorrelation { p_value, neighbours, time: times[at], timed: sequence.timed }
}

/// Rows of all axes below each other.
fn stacked(axes: &[DMatrix<f64>; 3]) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(axes.iter().map(DMatrix::nrows).sum(), axes[0].ncols());
    let mut first = 0;
    for axis in axes {
        all.rows_mut(first, axis.nrows()).copy_from(axis);
        first += axis.nrows();
    }
    all
}

/// S of a positive semidefinite matrix with S Sᵀ = it.
fn root(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    if matrix.is_empty() {
        return matrix.clone();
    }
    let SymmetricEigen { mut eigenvectors, eigenvalues } = SymmetricEigen::new(matrix.clone());
    for (mut vector, value) in eigenvectors.column_iter_mut().zip(eigenvalues.iter()) {
        vector *= value.max(0.0).sqrt();
    }
    eigenvectors
}

/// S of means of all axes.
struct Statistic {
    /// Rows of each axis.
    axes: [Range<usize>; 3],
    /// exp(−Δt/T) from each pose to the next on each axis, for each T.
    kept: Vec<[Vec<f64>; 3]>,
    /// E and sd of U_T.
    moments: Vec<(f64, f64)>,
    /// Dimension of the space of projected noise.
    freedom: f64,
}

impl Statistic {
    /// `basis`: rows of Q of all means.
    fn new(sequence: &Sequence, times: &[f64], basis: &DMatrix<f64>) -> Self {
        let mut first = 0;
        let axes = sequence.axes.each_ref().map(|axis| {
            let own = first..first + axis.len();
            first = own.end;
            own
        });
        let forgotten = |axis: &Vec<Mean>, time: f64| {
            axis.windows(2).map(|pair| (-(pair[1].at - pair[0].at) / time).exp()).collect()
        };
        let kept: Vec<[Vec<f64>; 3]> =
            times.iter().map(|&time| sequence.axes.each_ref().map(|axis| forgotten(axis, time))).collect();
        let turned = axes.each_ref().map(|own| basis.rows(own.start, own.len()).transpose());
        let moments = kept.par_iter().map(|kept| moments(kept, &turned)).collect();
        let freedom = sequence.len() as f64 - basis.norm_squared();
        Statistic { axes, kept, moments, freedom }
    }

    /// S and the number of its time constant.
    fn of(&self, means: &[f64]) -> (f64, usize) {
        let squares: f64 = means.iter().map(|e| e * e).sum();
        let each = self.kept.iter().zip(&self.moments).map(|(kept, (mean, sd))| {
            let sum: f64 =
                kept.iter().zip(&self.axes).map(|(kept, own)| pairs(kept, &means[own.clone()])).sum();
            (sum * self.freedom / squares.max(f64::MIN_POSITIVE) - mean) / sd
        });
        each.enumerate()
            .map(|(k, s)| (s, k))
            .fold((f64::NEG_INFINITY, 0), |a, b| if b.0 > a.0 { b } else { a })
    }
}

/// Σ_{v≠w} e_v e_w exp(−|t_v − t_w|/T) of one axis; `kept`: exp(−Δt/T) from each pose to the next.
fn pairs(kept: &[f64], e: &[f64]) -> f64 {
    let (mut sum, mut behind) = (0.0, 0.0);
    for (kept, pair) in kept.iter().zip(e.windows(2)) {
        behind = (behind + pair[0]) * kept;
        sum += 2.0 * behind * pair[1];
    }
    sum
}

/// Mean and standard deviation of the sum of pairs of projected noise, P = 1 − QQᵀ: tr PK, 2 tr PKPK. `basis`: Qᵀ of each axis, r × poses.
fn moments(kept: &[Vec<f64>; 3], basis: &[DMatrix<f64>; 3]) -> (f64, f64) {
    let (mut squares, mut half) = (0.0, 0.0);
    let r = basis[0].nrows();
    let mut inner: DMatrix<f64> = DMatrix::zeros(r, r);
    for (kept, q) in kept.iter().zip(basis) {
        let mut kq = DMatrix::zeros(r, q.ncols());
        let (mut behind, mut behind_squares) = (DVector::<f64>::zeros(r), 0.0);
        for (k, f) in kept.iter().enumerate() {
            behind += q.column(k);
            behind *= *f;
            behind_squares = (behind_squares + 1.0) * f * f;
            squares += 2.0 * behind_squares;
            kq.column_mut(k + 1).copy_from(&behind);
        }
        let mut ahead = DVector::<f64>::zeros(r);
        for (k, f) in kept.iter().enumerate().rev() {
            ahead += q.column(k + 1);
            ahead *= *f;
            let mut column = kq.column_mut(k);
            column += &ahead;
        }
        inner += cross(&q.transpose(), &kq.transpose());
        half += kq.norm_squared();
    }
    let variance = 2.0 * (squares - 2.0 * half + inner.norm_squared());
    (-inner.trace(), variance.max(f64::MIN_POSITIVE).sqrt())
}

fn gaussian(random: &mut ChaCha8Rng) -> f64 {
    // Box and Muller (1958).
    let (u, v): (f64, f64) = (random.random::<f64>(), random.random::<f64>());
    (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

fn normal_tail(z: f64) -> f64 {
    0.5 * statrs::function::erf::erfc(z * std::f64::consts::FRAC_1_SQRT_2)
}
