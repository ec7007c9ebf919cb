//! The poses in the order in which they were measured, and their covariance when instrument or robot wander on the way.
//!
//! ```text
//! μ_v = x_v + w(t_v) + e_v,     E w(t) w(t') = b exp(−|t − t'| / T),     var e_v = a v_v,     v_v = ρ² + 1/Σ 1/σ²
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | μ_v, x_v | weighted mean of what was measured of one pose and axis, and what the model says of it | m |
//! | w | Ornstein–Uhlenbeck process (Matérn ½; AR(1) where poses are evenly spaced), one for each axis | m |
//! | v_v, a | variance of the mean when poses are independent, and the part of it that stays | m², 1 |
//! | b, T | variance and time constant of the wander | m², s (poses without time) |
//!
//! What differs within a pose does not see the wander. w is a Markov process, so that a Kalman filter over the means whitens any columns in
//! one pass (Kalman 1960; Schweppe 1965 for the likelihood of its innovations). a, b and T are those of the largest restricted likelihood
//! (Patterson and Thompson 1971), the model's unknowns integrated out over their prior.

use crate::problem::linearisation::Linearisation;
use crate::problem::whitening::{self, Whitener};
use crate::statistics::product::{cholesky, gram_matrix};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// One pose on one axis.
#[derive(Debug, Clone)]
pub(crate) struct Mean {
    /// When, in steps.
    pub at: f64,
    /// Its observations, and the part of each in the whitened mean.
    pub members: Vec<(usize, f64)>,
    /// v, m².
    pub variance: f64,
}

/// The means of all poses, axis by axis, in order.
#[derive(Debug, Clone)]
pub(crate) struct Sequence {
    pub axes: [Vec<Mean>; 3],
    /// A step: the median time from a pose to the next, s; 1 where there is no time.
    pub step: f64,
    pub timed: bool,
    /// From the first pose to the last, in steps.
    pub span: f64,
    /// Median of v, m².
    pub typical: f64,
}

/// a, b/(typical v) and T in steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Process {
    pub white: f64,
    pub wander: f64,
    pub time: f64,
}

impl Process {
    /// Half white, half a wander of this time constant, in steps.
    pub fn begun(time: f64) -> Self {
        Process { white: 0.5, wander: 0.5, time }
    }
}

impl Sequence {
    /// None with fewer than ten poses: nothing can be told of an order then.
    pub fn of(linearisation: &Linearisation<'_>, whitener: &Whitener) -> Option<Self> {
        const FEWEST: usize = 10;
        let data = linearisation.data;
        let spread =
            data.time.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &t| [a.min(t), b.max(t)]);
        let timed = data.has_clock() && spread[1] > spread[0];
        let mut axes: [Vec<Mean>; 3] = Default::default();
        // A displacement along directions that turn with the robot is no series in time.
        for mean in whitener.means().filter(|mean| mean.on_axis) {
            let whitening::Mean { members, weights, variance, .. } = mean;
            let first = linearisation.observations[members[0]];
            if first.component < 3 {
                let length = weights.iter().map(|d| d * d).sum::<f64>().sqrt();
                let members = members.iter().zip(weights).map(|(&at, d)| (at, d / length)).collect();
                let at = if timed { data.time[first.row] } else { first.visit as f64 };
                axes[first.component].push(Mean { at, members, variance });
            }
        }
        let mut times: Vec<f64> =
            axes.iter().max_by_key(|axis| axis.len())?.iter().map(|mean| mean.at).collect();
        if times.len() < FEWEST {
            return None;
        }
        times.sort_by(f64::total_cmp);
        let mut gaps: Vec<f64> =
            times.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > 0.0).collect();
        gaps.sort_by(f64::total_cmp);
        let step = *gaps.get(gaps.len() / 2)?;
        let start = times[0];
        for mean in axes.iter_mut().flatten() {
            mean.at = (mean.at - start) / step;
        }
        axes.iter_mut().for_each(|axis| axis.sort_by(|a, b| a.at.total_cmp(&b.at)));
        let mut variances: Vec<f64> = axes.iter().flatten().map(|mean| mean.variance).collect();
        variances.sort_by(f64::total_cmp);
        let typical = variances[variances.len() / 2];
        Some(Sequence { axes, step, timed, span: (times[times.len() - 1] - start) / step, typical })
    }

    /// How many means there are.
    pub fn len(&self) -> usize {
        self.axes.iter().map(Vec::len).sum()
    }

    /// The whitened means of whitened columns, axis by axis: rows in order.
    pub fn means(&self, white: &DMatrix<f64>) -> [DMatrix<f64>; 3] {
        let of = |axis: &Vec<Mean>| {
            let mut means = DMatrix::zeros(axis.len(), white.ncols());
            for (column, mut to) in white.column_iter().zip(means.column_iter_mut()) {
                for (mean, to) in axis.iter().zip(to.iter_mut()) {
                    *to = mean.members.iter().map(|&(at, part)| part * column[at]).sum();
                }
            }
            means
        };
        [of(&self.axes[0]), of(&self.axes[1]), of(&self.axes[2])]
    }
}

/// Columns [A | X | y] with what their likelihood needs; X is not integrated out.
pub(crate) struct Ordered<'s> {
    sequence: &'s Sequence,
    /// Whitened means of each axis: columns × poses.
    means: [DMatrix<f64>; 3],
    /// Gram matrix of what differs within poses, and of orientations.
    within: DMatrix<f64>,
    prior: DMatrix<f64>,
    /// Columns of A.
    known: usize,
}

impl<'s> Ordered<'s> {
    /// `white`: whitened [A | X | y] of which the first `known` columns are A; `prior`: rows of A's prior.
    pub fn new(
        sequence: &'s Sequence,
        white: &DMatrix<f64>,
        known: usize,
        prior: Option<&DMatrix<f64>>,
    ) -> Self {
        let means = sequence.means(white);
        let mut within = gram_matrix(white);
        means.iter().for_each(|means| within -= gram_matrix(means));
        let n = white.ncols() - 1;
        let mut precision = DMatrix::zeros(n, n);
        if let Some(rows) = prior {
            precision.view_mut((0, 0), (known, known)).copy_from(&gram_matrix(rows));
        }
        Ordered { sequence, means: means.map(|axis| axis.transpose()), within, prior: precision, known }
    }

    /// −2 ln of the restricted likelihood, up to a constant that is the same for all processes and X.
    pub fn deviance(&self, of: Process) -> f64 {
        let n = self.prior.ncols();
        let (mut gram, mut logarithm) = (self.within.clone(), 0.0);
        let axes: Vec<(&Vec<Mean>, &DMatrix<f64>)> = self.sequence.axes.iter().zip(&self.means).collect();
        let each: Vec<(DMatrix<f64>, f64)> = axes
            .into_par_iter()
            .map(|(axis, means)| innovations(axis, means, of, self.sequence.typical))
            .collect();
        for (own, log) in each {
            gram += own;
            logarithm += log;
        }
        let mut normal = gram.view((0, 0), (n, n)) + &self.prior;
        let scale: Vec<f64> =
            normal.diagonal().iter().map(|&d| if d > 0.0 { 1.0 / d.sqrt() } else { 1.0 }).collect();
        for j in 0..n {
            (0..n).for_each(|i| normal[(i, j)] *= scale[i] * scale[j]);
            normal[(j, j)] += 1e-12;
        }
        let Some(factor) = cholesky(normal) else { return f64::INFINITY };
        let mut along = DVector::from_fn(n, |i, _| gram[(i, n)] * scale[i]);
        let lower = factor.l_dirty();
        lower.solve_lower_triangular_mut(&mut along);
        let known: f64 = (0..self.known).map(|k| 2.0 * (lower[(k, k)] / scale[k]).ln()).sum();
        logarithm + known + (gram[(n, n)] - along.norm_squared()).max(0.0)
    }

    /// The process of the largest likelihood, found by a pattern search from this one (Hooke and Jeeves 1961).
    pub fn fitted(&self, start: Process) -> (Process, f64) {
        let mut steps = [1.0, 1.4, 1.4];
        /// Logarithms are wanted to this.
        const FINE: f64 = 0.08;
        let longest = (0.5 * self.sequence.span).max(1.0);
        let (mut best, mut least) = (start, self.deviance(start));
        while steps.iter().any(|step| *step > FINE) {
            let before = least;
            for (which, step) in steps.iter().enumerate() {
                for sign in [1.0, -1.0] {
                    let factor = (sign * step).exp();
                    let mut trial = best;
                    match which {
                        0 => trial.white = (trial.white * factor).max(1e-3),
                        1 => trial.wander *= factor,
                        _ => trial.time = (trial.time * factor).clamp(0.3, longest),
                    }
                    let value = self.deviance(trial);
                    if value < least {
                        (best, least) = (trial, value);
                        break;
                    }
                }
            }
            if before - least < 0.05 {
                steps.iter_mut().for_each(|step| *step *= 0.4);
            }
        }
        (best, least)
    }
}

/// Gram matrix of the whitened innovations of one axis' means (columns × poses), and the logarithm of their variances over those of
/// independent poses.
fn innovations(axis: &[Mean], means: &DMatrix<f64>, of: Process, typical: f64) -> (DMatrix<f64>, f64) {
    /// Poses whose innovations are in memory.
    const AT_ONCE: usize = 256;
    let n = means.nrows();
    let stationary = of.wander * typical;
    let (mut gram, mut state) = (DMatrix::zeros(n, n), DVector::<f64>::zeros(n));
    let (mut variance, mut logarithm) = (stationary, 0.0);
    for first in (0..axis.len()).step_by(AT_ONCE) {
        let mut white = means.columns(first, AT_ONCE.min(axis.len() - first)).into_owned();
        for (k, mut innovation) in (first..).zip(white.column_iter_mut()) {
            let mean = &axis[k];
            let kept = if k == 0 { 1.0 } else { (-(mean.at - axis[k - 1].at) / of.time).exp() };
            variance = kept * kept * variance + stationary * (1.0 - kept * kept);
            let whole = variance + of.white * mean.variance;
            let gain = variance / whole;
            let (size, unit) = (mean.variance.sqrt(), 1.0 / whole.sqrt());
            for (to, x) in innovation.iter_mut().zip(state.iter_mut()) {
                let predicted = *x * kept;
                let new = *to * size - predicted;
                *x = predicted + gain * new;
                *to = new * unit;
            }
            variance *= 1.0 - gain;
            logarithm += (whole / mean.variance).ln();
        }
        gram += gram_matrix(&white.transpose());
    }
    (gram, logarithm)
}
