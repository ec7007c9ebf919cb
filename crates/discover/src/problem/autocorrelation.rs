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
use crate::statistics::product::{cross, orthonormal};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Normal vectors of the test.
const DRAWS: usize = 999;
/// How many of them are in memory.
const AT_ONCE: usize = 64;
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
    let q = orthonormal(joined);
    let (top, bottom) = (q.rows(0, m).into_owned(), q.rows(m, below).into_owned());
    let y = white.column(r);
    let residual = y - &top * top.tr_mul(&y);
    let mut times = vec![1.0];
    while times[times.len() - 1] * 3.0 < 0.3 * sequence.span {
        times.push(times[times.len() - 1] * 3.0);
    }
    let basis = sequence.means(&top);
    let moments: Vec<(f64, f64)> = times.iter().map(|&time| moments(sequence, &basis, time)).collect();
    let freedom = sequence.len() as f64 - basis.iter().map(DMatrix::norm_squared).sum::<f64>();
    let score = |means: &[DMatrix<f64>; 3], column: usize| -> (f64, usize) {
        let squares: f64 = means.iter().map(|axis| axis.column(column).norm_squared()).sum();
        let each = times.iter().zip(&moments).map(|(&time, (mean, sd))| {
            let sum: f64 =
                sequence.axes.iter().zip(means).map(|(axis, e)| pairs(axis, e, column, time)).sum();
            (sum * freedom / squares.max(f64::MIN_POSITIVE) - mean) / sd
        });
        each.enumerate()
            .map(|(k, s)| (s, k))
            .fold((f64::NEG_INFINITY, 0), |a, b| if b.0 > a.0 { b } else { a })
    };
    let own = sequence.means(&DMatrix::from_column_slice(m, 1, residual.as_slice()));
    let (largest, at) = score(&own, 0);
    let p_value = if largest < CLOSE {
        (times.len() as f64 * normal_tail(largest)).clamp(0.0, 1.0)
    } else {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x7d11_c0de);
        let mut above = 0;
        for first in (0..DRAWS).step_by(AT_ONCE) {
            let count = AT_ONCE.min(DRAWS - first);
            let noise = DMatrix::from_fn(m + below, count, |_, _| gaussian(&mut random));
            let along = top.tr_mul(&noise.rows(0, m)) + bottom.tr_mul(&noise.rows(m, below));
            let drawn = sequence.means(&(noise.rows(0, m) - &top * along));
            above += (0..count).into_par_iter().filter(|&k| score(&drawn, k).0 >= largest).count();
        }
        (1.0 + above as f64) / (1.0 + DRAWS as f64)
    };
    // Of neighbours alone: what is expected of independent poses is taken off.
    let (mut next, mut expected) = (0.0, 0.0);
    for (e, q) in own.iter().zip(&basis) {
        for k in 1..e.nrows() {
            next += e[k] * e[k - 1];
            expected -= q.row(k).dot(&q.row(k - 1));
        }
    }
    let squares: f64 = own.iter().map(DMatrix::norm_squared).sum();
    let neighbours = next / squares.max(f64::MIN_POSITIVE) - expected / freedom.max(1.0);
    Autocorrelation { p_value, neighbours, time: times[at], timed: sequence.timed }
}

/// Σ_{v≠w} e_v e_w exp(−|t_v − t_w|/T) of one axis.
fn pairs(axis: &[Mean], e: &DMatrix<f64>, column: usize, time: f64) -> f64 {
    let (mut sum, mut behind) = (0.0, 0.0);
    for k in 1..axis.len() {
        behind = (behind + e[(k - 1, column)]) * (-(axis[k].at - axis[k - 1].at) / time).exp();
        sum += 2.0 * behind * e[(k, column)];
    }
    sum
}

/// Mean and standard deviation of the sum of pairs of projected noise, P = 1 − QQᵀ: tr PK, 2 tr PKPK.
fn moments(sequence: &Sequence, basis: &[DMatrix<f64>; 3], time: f64) -> (f64, f64) {
    let (mut squares, mut half) = (0.0, 0.0);
    let r = basis[0].ncols();
    let mut inner: DMatrix<f64> = DMatrix::zeros(r, r);
    for (axis, q) in sequence.axes.iter().zip(basis) {
        let mut kq = DMatrix::zeros(q.nrows(), r);
        let forget = |k: usize| (-(axis[k].at - axis[k - 1].at) / time).exp();
        let (mut behind, mut behind_squares) = (nalgebra::RowDVector::zeros(r), 0.0);
        for k in 1..axis.len() {
            let f = forget(k);
            behind = (behind + q.row(k - 1)) * f;
            behind_squares = (behind_squares + 1.0) * f * f;
            squares += 2.0 * behind_squares;
            kq.row_mut(k).copy_from(&behind);
        }
        let mut ahead = nalgebra::RowDVector::zeros(r);
        for k in (1..axis.len()).rev() {
            ahead = (ahead + q.row(k)) * forget(k);
            let mut row = kq.row_mut(k - 1);
            row += &ahead;
        }
        inner += cross(q, &kq);
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
