//! What the present model leaves, and candidates with everything that it explains projected out.
//!
//! ```text
//! A W⁻¹ = U Σ Vᵀ,   Q = [Q_1; Q_2] orthonormal basis of [U_s Σ_s, U_w Σ_w; 0, 1],   s: σ ≥ 3,   w: σ < 3
//! r̃ = y − Q_1 Q_1ᵀ y,   X̃ = X − Q_1 Q_1ᵀ X,   X̃ᵀX̃ (with the prior's rows) = XᵀX − (Q_1ᵀX)ᵀ Q_1ᵀX
//! ```
//!
//! all whitened. Directions s are estimated by the data; directions w are held by the prior W and count as random effects of its width. With an
//! orthonormal basis T of the projected candidate, `SS = ‖Tᵀ Xᵀ r̃‖²` is its part of the sum of squares RSS (score test, no
//! refit), and `LR = −m ln(1 − SS/RSS)`. Candidates of different numbers of coefficients are compared by the p of SS/RSS as a single test,
//! `Beta(k/2, (ν − k)/2)` ([`crate::statistics::beta`]). A direction of which the present model explains nearly all is left out: the data
//! cannot judge it.

use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::problem::basis::{basis, gain};
use crate::problem::linearisation::Linearisation;
use crate::problem::noise::Noise;
use crate::problem::tables::{Sums, Tables};
use crate::problem::whitening::Whitener;
use crate::statistics::beta::surprisal;
use crate::statistics::product::{cross, gram_matrix, orthonormal, orthonormal_again, product};
use nalgebra::{DMatrix, DVector, Dyn, Matrix, Scalar, Storage};
use std::sync::OnceLock;
use truepose_solvers::kernels::symmetric_eigen;

/// The present model, projected out.
pub(crate) struct Projection {
    pub whitener: Whitener,
    /// Explained fraction left of a direction below which the model absorbs it.
    pub absorbed: f64,
    /// Q_1, m × r.
    pub q: DMatrix<f64>,
    /// y, m.
    y: DVector<f64>,
    /// r̃, m.
    pub residual: DVector<f64>,
    /// ‖r̃‖² with the prior's rows.
    pub rss: f64,
    /// ν: dimension of the space in which the direction of the residual is uniform when nothing is missing.
    pub freedom: usize,
    /// For each of the last columns of Q_1, of directions that the prior holds as much as the data: its length in the prior's rows.
    pub held: Vec<f64>,
    tables: OnceLock<Tables>,
}

/// How a candidate does against what is left.
#[derive(Debug, Clone)]
pub(crate) struct Score {
    /// Directions that the data can judge.
    pub freedom: usize,
    /// −m ln(1 − SS/RSS).
    pub gain: f64,
    /// −ln p of the fraction that it explains, as a single test.
    pub surprisal: f64,
    /// Share of the candidate that the present model does not absorb, ‖X̃‖²/‖X‖².
    pub share: f64,
    /// T: makes the projected columns orthonormal, k × freedom.
    pub basis: DMatrix<f32>,
}

/// Directions whose singular value, of the whitened columns in standard deviations of the prior, is at least this are estimated by the data;
/// weaker ones are shrunk by the prior to less than nine tenths, and count as random effects of its width.
const ESTIMATED: f64 = 3.0;

impl Projection {
    /// Under the noise of the present model.
    pub fn new(linearisation: &Linearisation<'_>) -> Self {
        Projection::under(linearisation, linearisation.noise)
    }

    /// Under another noise model.
    pub fn under(linearisation: &Linearisation<'_>, noise: Noise) -> Self {
        let whitener = linearisation.whitener(noise);
        let columns = whitener.of(&linearisation.base);
        let y = whitener.of(&DMatrix::from_column_slice(linearisation.len(), 1, linearisation.y.as_slice()));
        let y = y.column(0).into_owned();
        let (q, held) = directions(columns, linearisation.prior.as_ref());
        let along = q.tr_mul(&y);
        let residual = &y - &q * &along;
        let first = q.ncols() - held.len();
        let in_prior: f64 = held.iter().enumerate().map(|(k, h)| (h * along[first + k]).powi(2)).sum();
        let rss = residual.norm_squared() + in_prior;
        let freedom = linearisation.len().saturating_sub(first);
        Projection {
            absorbed: linearisation.policy.absorbed,
            whitener,
            q,
            y,
            residual,
            rss,
            freedom,
            held,
            tables: OnceLock::new(),
        }
    }

    /// What an error at a site does, visit by visit, under the noise of this projection.
    pub fn tables(&self, linearisation: &Linearisation<'_>) -> &Tables {
        self.tables.get_or_init(|| Tables::new(linearisation, &self.whitener, &self.residual))
    }

    /// With further raw columns (m × k) in the present model; none when nothing of them is left.
    pub fn with(&self, more: &DMatrix<f64>) -> Option<Self> {
        let (new, explained) = self.directions(more)?;
        let residual = &self.residual - &new * &explained;
        let (r, k) = (self.q.ncols(), new.ncols());
        let mut q = self.q.clone().resize_horizontally(r + k, 0.0);
        q.columns_mut(r, k).copy_from(&new);
        Some(Projection {
            whitener: self.whitener.clone(),
            absorbed: self.absorbed,
            rss: self.rss - explained.norm_squared(),
            freedom: self.freedom.saturating_sub(k),
            held: self.held.clone(),
            tables: self.tables.get().map_or_else(OnceLock::new, |known| known.with(&residual).into()),
            q,
            y: self.y.clone(),
            residual,
        })
    }

    /// Directions that raw columns (m × k) add to Q_1, and what they explain of y.
    fn directions(&self, more: &DMatrix<f64>) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let new = self.left_of(more)?;
        // With what they have in the prior's rows they are orthogonal to the known ones, so that y, which has nothing
        // there, tells what they explain.
        let explained = new.tr_mul(&self.y);
        Some((new, explained))
    }

    /// An orthonormal basis of what the present model leaves of raw columns (m × k): m × freedom; none when nothing of them is left.
    fn left_of(&self, columns: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let x = self.whitener.of(columns);
        let along = cross(&self.q, &x);
        let raw = gram_matrix(&x);
        let basis = basis(&raw, &(&raw - gram_matrix(&along)), self.absorbed)?;
        Some((x - product(&self.q, &along)) * basis)
    }

    /// Whitened columns of a candidate, m × k, with Φ of each visit's first row.
    pub fn columns(
        &self,
        linearisation: &Linearisation<'_>,
        candidate: &Candidate,
    ) -> Result<DMatrix<f64>, DiscoverError> {
        let Change::Add(effects) = &candidate.change else {
            return Ok(self.whitener.of(&linearisation.columns_of(candidate)?));
        };
        let evaluated = linearisation.evaluate(effects)?;
        let mut columns = DMatrix::zeros(self.len(), evaluated.width());
        let tables = self.tables(linearisation);
        let stations = tables.stations.iter().copied();
        evaluated.each(stations, &mut |visit, entries| tables.put(visit, entries, &mut columns))?;
        Ok(columns)
    }

    /// What is needed of each of these candidates' whitened columns: their products with Q_1 are one of two matrices.
    pub fn sums_of(&self, candidates: &[DMatrix<f64>]) -> Vec<Sums> {
        if candidates.is_empty() {
            return Vec::new();
        }
        let along = cross(&self.q, &side_by_side(candidates, |v| v));
        let mut first = 0;
        let of = |x: &DMatrix<f64>| {
            let along = along.columns(first, x.ncols()).into_owned();
            first += x.ncols();
            Sums { along, raw: gram_matrix(x), score: x.tr_mul(&self.residual) }
        };
        candidates.iter().map(of).collect()
    }

    /// Fraction of RSS that raw columns (m × k) explain; zero when nothing of them is left.
    pub fn explained(&self, columns: &DMatrix<f64>) -> f64 {
        let x = self.whitener.of(columns);
        let along = cross(&self.q, &x);
        let score = x.tr_mul(&self.residual);
        self.judged(&gram_matrix(&x), &along, &score)
            .map_or(0.0, |score| 1.0 - (-score.gain / self.len() as f64).exp())
    }

    /// Scores along the orthonormal basis of raw columns (m × k), summed by pose: poses × freedom; none when nothing of them is left.
    pub fn scores_by(
        &self,
        columns: &DMatrix<f64>,
        pose: impl Iterator<Item = usize>,
    ) -> Option<DMatrix<f64>> {
        let left = self.left_of(columns)?;
        let pose: Vec<usize> = pose.collect();
        let count = pose.iter().max().map_or(0, |last| last + 1);
        let mut scores = DMatrix::zeros(count, left.ncols());
        for (at, &pose) in pose.iter().enumerate() {
            for k in 0..left.ncols() {
                scores[(pose, k)] += left[(at, k)] * self.residual[at];
            }
        }
        Some(scores)
    }

    /// How many numbers were measured.
    pub fn len(&self) -> usize {
        self.residual.len()
    }

    /// How a candidate does; none when nothing of it is left, or the data lacks what it reads.
    pub fn judge(&self, linearisation: &Linearisation<'_>, candidate: &Candidate) -> Option<Score> {
        self.score(&self.sums(linearisation, candidate).ok()?)
    }

    /// What is needed of a candidate's columns.
    pub fn sums(
        &self,
        linearisation: &Linearisation<'_>,
        candidate: &Candidate,
    ) -> Result<Sums, DiscoverError> {
        let x = self.columns(linearisation, candidate)?;
        Ok(Sums { along: cross(&self.q, &x), raw: gram_matrix(&x), score: x.tr_mul(&self.residual) })
    }

    /// The score of a candidate; none when nothing of it is left.
    pub fn score(&self, sums: &Sums) -> Option<Score> {
        self.judged(&sums.raw, &sums.along, &sums.score)
    }

    /// The score from XᵀX, Q_1ᵀX and Xᵀr̃.
    pub fn judged<A>(
        &self,
        raw: &DMatrix<f64>,
        along: &Matrix<f64, Dyn, Dyn, A>,
        score: &DVector<f64>,
    ) -> Option<Score>
    where
        A: Storage<f64, Dyn, Dyn>,
    {
        let left = raw - gram_matrix(&along.clone_owned());
        let total = raw.trace();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let basis = basis(raw, &left, self.absorbed)?;
        let freedom = basis.ncols();
        let squares = basis.tr_mul(score).norm_squared();
        Some(Score {
            freedom,
            gain: gain(self.len(), squares, self.rss),
            surprisal: surprisal(squares / self.rss, freedom, self.freedom),
            share: left.trace() / total,
            basis: basis.map(|v| v as f32),
        })
    }
}

/// Matrices of equally many rows side by side, each number `of` what it was.
pub(crate) fn side_by_side<T: Scalar>(parts: &[DMatrix<f64>], of: impl Fn(f64) -> T) -> DMatrix<T> {
    let rows = parts.first().map_or(0, DMatrix::nrows);
    let all: Vec<T> = parts.iter().flat_map(|part| part.iter().map(|&v| of(v))).collect();
    DMatrix::from_vec(rows, all.len() / rows.max(1), all)
}

/// Orthonormal directions of `[A; W]`: those that the data estimates, free of the prior, then those that the prior holds, with the length
/// of each in the prior's rows.
fn directions(columns: DMatrix<f64>, prior: Option<&DMatrix<f64>>) -> (DMatrix<f64>, Vec<f64>) {
    let apart = prior.and_then(|prior| without_prior(&columns, prior));
    let Some(scaled) = apart else { return (orthonormal(columns), Vec::new()) };
    let Some((values, vectors)) = symmetric_eigen(&gram_matrix(&scaled)) else {
        return (orthonormal(columns), Vec::new());
    };
    let strong = |&k: &usize| values[k] >= ESTIMATED * ESTIMATED;
    let (estimated, weak): (Vec<usize>, Vec<usize>) = (0..values.len()).partition(strong);
    let turned = |which: &[usize]| product(&scaled, &vectors.select_columns(which));
    let free = orthonormal_again(turned(&estimated));
    let mut rest = turned(&weak);
    rest -= product(&free, &cross(&free, &rest));
    let mut held = Vec::new();
    let mut q = free.resize_horizontally(estimated.len() + weak.len(), 0.0);
    for (k, mut column) in rest.column_iter_mut().enumerate() {
        let length = (1.0 + column.norm_squared()).sqrt();
        column /= length;
        held.push(1.0 / length);
        q.set_column(estimated.len() + k, &column);
    }
    (q, held)
}

/// `A W⁻¹`; none where W has none. Of its last unknowns that are held one by one, as those of a wander, no inverse of a matrix is needed.
fn without_prior(columns: &DMatrix<f64>, prior: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = prior.ncols();
    let alone = |k: &usize| (0..n).all(|i| i == *k || (prior[(i, *k)] == 0.0 && prior[(*k, i)] == 0.0));
    let together = n - (0..n).rev().take_while(alone).count();
    let inverse = prior.view((0, 0), (together, together)).into_owned().try_inverse()?;
    let mut scaled =
        product(&columns.columns(0, together).into_owned(), &inverse).resize_horizontally(n, 0.0);
    for k in together..n {
        let by = prior[(k, k)];
        if by == 0.0 {
            return None;
        }
        scaled.set_column(k, &(columns.column(k) / by));
    }
    Some(scaled)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknowns_that_are_held_one_by_one_need_no_inverse_of_a_matrix() {
        let columns = DMatrix::from_fn(20, 6, |i, j| ((i * 5 + j * j) as f64).sin());
        for together in [0, 2, 6] {
            let mut prior = DMatrix::from_diagonal(&DVector::from_fn(6, |k, _| 0.5 + k as f64));
            for i in 0..together {
                (i + 1..together).for_each(|j| prior[(i, j)] = 0.3);
            }
            let found = without_prior(&columns, &prior).unwrap();
            assert!((found - &columns * prior.clone().try_inverse().unwrap()).amax() < 1e-14, "{together}");
        }
        assert!(without_prior(&columns, &DMatrix::zeros(6, 6)).is_none());
    }
}
