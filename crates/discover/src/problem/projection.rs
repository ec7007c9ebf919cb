//! What the present model leaves, and candidates with everything that it explains projected out.
//!
//! ```text
//! [A; W] = [Q_1; Q_2] R,   r̃ = y − Q_1 Q_1ᵀ y,   X̃ = X − Q_1 Q_1ᵀ X,   X̃ᵀX̃ (with the prior's rows) = XᵀX − (Q_1ᵀX)ᵀ Q_1ᵀX
//! ```
//!
//! all whitened. With an orthonormal basis T of the projected candidate, `SS = ‖Tᵀ Xᵀ r̃‖²` is what it would take from
//! the sum of squares RSS (score test, no refit), and `LR = −m ln(1 − SS/RSS)`. Statistics of different numbers of
//! unknowns are compared by how surprising they are. A direction of which the present model already
//! explains nearly all is left out: there the data cannot speak for the candidate.
//!
//! What causes that have not been found yet do to a visit they do to all of its numbers, so that m numbers are worth less, and a candidate
//! may shine in a few visits alone. If each visit had a sign by chance, its share would have, with b_u its scores of one visit and
//! B those of all (units × k),
//!
//! ```text
//! E SS = Σ_u ‖b_u‖²,   Var SS = 2 (‖BᵀB‖² − Σ_u ‖b_u‖⁴)
//! ```
//!
//! (of k directions in white noise k and 2k deviations squared). How surprising the share is *among visits* is told from the beta law with
//! these moments; how surprising it is among numbers, from LR.

use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, Change};
use crate::problem::linearisation::Scene;
use crate::problem::tables::{Sums, Tables};
use crate::problem::whitening::Whitener;
use crate::statistics::beta::Share;
use crate::statistics::product::{cross, orthonormal};
use crate::statistics::surprisal::Surprise;
use nalgebra::{DMatrix, DVector, Dyn, Matrix, Storage, SymmetricEigen};

/// Directions of which less than this share is left are absorbed by the present model.
const ABSORBED: f64 = 2e-3;

/// The present model, projected out.
pub(crate) struct Projection {
    pub whitener: Whitener,
    /// Q_1, m × r.
    pub q: DMatrix<f64>,
    /// y, m.
    y: DVector<f64>,
    /// r̃, m.
    pub residual: DVector<f64>,
    /// ‖r̃‖² with the prior's rows.
    pub rss: f64,
    /// The exchangeable unit of each number, and how many there are.
    pub unit: Vec<usize>,
    pub units: usize,
    /// Q_1 ∘ r̃ summed over each unit, units × r.
    pub q_by_unit: DMatrix<f64>,
    /// ‖P S r̃‖² as it is to be expected with random signs S of the units.
    flipped: f64,
    pub tables: Tables,
}

/// A candidate, heard once.
#[derive(Debug, Clone)]
pub(crate) struct Heard {
    sums: Sums,
    /// (visit, column, site, value).
    said: Vec<(usize, usize, usize, f64)>,
    /// Whitened columns of what is no effect.
    dense: Option<DMatrix<f64>>,
}

/// How a candidate does against what is left.
#[derive(Debug, Clone)]
pub(crate) struct Score {
    /// Directions that the data can judge.
    pub freedom: usize,
    /// −m ln(1 − SS/RSS).
    pub gain: f64,
    /// Of the share that it takes by chance.
    pub law: Share,
    /// How surprising that is.
    pub surprise: Surprise,
    /// Share of the candidate that the present model does not absorb, ‖X̃‖²/‖X‖².
    pub share: f64,
    /// Scores of the units along the orthonormal basis, units × freedom.
    pub by_unit: DMatrix<f32>,
}

/// More units than this are merged, neighbours in time together.
const MOST_UNITS: usize = 400;

impl Projection {
    pub fn new(scene: &Scene<'_>) -> Self {
        let whitener = scene.whitener(scene.noise);
        let mut joined = scene.base.clone();
        whitener.apply(&mut joined);
        let y = whitener.of(&DMatrix::from_column_slice(scene.len(), 1, scene.y.as_slice()));
        let m = scene.len();
        let extra = scene.prior.as_ref().map_or(0, DMatrix::nrows);
        joined = joined.resize_vertically(m + extra, 0.0);
        if let Some(prior) = &scene.prior {
            joined.rows_mut(m, extra).copy_from(prior);
        }
        let q = orthonormal(joined);
        let (top, bottom) = (q.rows(0, m).into_owned(), q.rows(m, extra).into_owned());
        let y = y.column(0).into_owned();
        let along = top.tr_mul(&y);
        let residual = &y - &top * &along;
        let rss = residual.norm_squared() + (&bottom * &along).norm_squared();
        let merge = scene.visits.div_ceil(MOST_UNITS).max(1);
        let unit: Vec<usize> = scene.observations.iter().map(|o| o.visit / merge).collect();
        let units = scene.visits.div_ceil(merge);
        let q_by_unit = by_unit(&top, &residual, &unit, units);
        let tables = Tables::new(scene, &whitener, (&top, &residual), &unit);
        let flipped = flipped(&residual, &q_by_unit);
        Projection { whitener, q: top, y, residual, rss, unit, units, q_by_unit, flipped, tables }
    }

    /// With further raw columns (m × k) in the present model; none when nothing of them is left.
    pub fn with(&self, more: &DMatrix<f64>) -> Option<Self> {
        let (new, explained) = self.directions(more)?;
        let residual = &self.residual - &new * &explained;
        let r = self.q.ncols();
        let mut q = self.q.clone().resize_horizontally(r + new.ncols(), 0.0);
        q.columns_mut(r, new.ncols()).copy_from(&new);
        let q_by_unit = by_unit(&q, &residual, &self.unit, self.units);
        Some(Projection {
            whitener: self.whitener.clone(),
            rss: self.rss - explained.norm_squared(),
            unit: self.unit.clone(),
            units: self.units,
            flipped: flipped(&residual, &q_by_unit),
            q_by_unit,
            tables: self.tables.with(&new, &residual),
            q,
            y: self.y.clone(),
            residual,
        })
    }

    /// Directions that raw columns (m × k) add to Q_1, and what they explain of y.
    fn directions(&self, more: &DMatrix<f64>) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let x = self.whitener.of(more);
        let along = cross(&self.q, &x);
        let raw = cross(&x, &x);
        let basis = basis(&raw, &(&raw - cross(&along, &along)))?;
        // With what they have in the prior's rows they are orthogonal to the known ones, so that y, which has nothing
        // there, tells what they explain.
        let new = (x - &self.q * along) * basis;
        let explained = new.tr_mul(&self.y);
        Some((new, explained))
    }

    /// What is needed of a candidate to ask for its gain beside others, again and again.
    pub fn hear(&self, scene: &Scene<'_>, candidate: &Candidate) -> Result<Heard, DiscoverError> {
        let mut heard = Heard { sums: self.sums(scene, candidate)?, said: Vec::new(), dense: None };
        match &candidate.change {
            Change::Add(effects) => {
                let stations = self.tables.stations.iter().copied();
                scene.ask(effects)?.each(stations, &mut |visit, entries| {
                    heard
                        .said
                        .extend(entries.iter().map(|&(column, site, value)| (visit, column, site, value)));
                })?;
            }
            Change::CorrectLoad { .. } => {
                heard.dense = Some(self.whitener.of(&scene.columns_of(candidate)?));
            }
        }
        Ok(heard)
    }

    /// The gain of candidates beside further raw columns (m × k): (gain, freedom) of each; none where nothing is left.
    pub fn beside(&self, more: &DMatrix<f64>, heard: &[&Heard]) -> Option<Vec<Option<(f64, usize)>>> {
        let (new, explained) = self.directions(more)?;
        let band = self.tables.band(&new);
        let residual = &self.residual - &new * &explained;
        let rss = self.rss - explained.norm_squared();
        // Columns of Q_1 are orthogonal to r̃ only together with the prior's rows.
        let (known, added) = (self.q.tr_mul(&residual), new.tr_mul(&residual));
        let gain = |heard: &&Heard| {
            let along = match &heard.dense {
                Some(columns) => cross(&new, columns),
                None => band.along(&heard.said, heard.sums.raw.ncols()),
            };
            let Sums { along: before, raw, by_unit } = &heard.sums;
            let left = raw - cross(before, before) - cross(&along, &along);
            let basis = basis(raw, &left)?;
            // X̃ᵀ r̃ with the new r̃.
            let score = by_unit.row_sum().transpose()
                - along.tr_mul(&explained)
                - before.tr_mul(&known)
                - along.tr_mul(&added);
            let squares = basis.tr_mul(&score).norm_squared();
            Some((self.gain(squares, rss), basis.ncols()))
        };
        Some(heard.iter().map(gain).collect())
    }

    /// How many numbers were measured.
    pub fn len(&self) -> usize {
        self.residual.len()
    }

    /// −m ln(1 − SS/RSS).
    pub fn gain(&self, squares: f64, rss: f64) -> f64 {
        -(self.len() as f64) * (1.0 - (squares / rss).min(1.0 - 1e-12)).ln()
    }

    /// The law of the share that a candidate with these scores by unit (units × freedom) takes by chance.
    pub fn law<S: Storage<f64, Dyn, Dyn>>(&self, by_unit: &Matrix<f64, Dyn, Dyn, S>) -> Share {
        let of_units = by_unit
            .row_iter()
            .map(|b| b.norm_squared())
            .fold((0.0, 0.0), |(sum, squares), b| (sum + b, squares + b * b));
        let (mean, fourth) = of_units;
        let variance = 2.0 * (cross(by_unit, by_unit).norm_squared() - fourth);
        Share::new(mean / self.flipped, variance / self.flipped.powi(2), self.len())
    }

    /// How a candidate does; none when nothing of it is left, or the data lacks what it reads.
    pub fn judge(&self, scene: &Scene<'_>, candidate: &Candidate) -> Option<Score> {
        self.score(&self.sums(scene, candidate).ok()?)
    }

    /// What is needed of a candidate's columns.
    pub fn sums(&self, scene: &Scene<'_>, candidate: &Candidate) -> Result<Sums, DiscoverError> {
        let Change::Add(effects) = &candidate.change else {
            let x = self.whitener.of(&scene.columns_of(candidate)?);
            let by_unit = by_unit(&x, &self.residual, &self.unit, self.units);
            return Ok(Sums { along: cross(&self.q, &x), raw: cross(&x, &x), by_unit });
        };
        let asked = scene.ask(effects)?;
        let width = asked.width();
        let mut sums = Sums {
            along: DMatrix::zeros(self.q.ncols(), width),
            raw: DMatrix::zeros(width, width),
            by_unit: DMatrix::zeros(self.units, width),
        };
        let stations = self.tables.stations.iter().copied();
        asked.each(stations, &mut |visit, entries| self.tables.add(visit, entries, &mut sums))?;
        Ok(sums)
    }

    /// The score of a candidate; none when nothing of it is left.
    pub fn score(&self, sums: &Sums) -> Option<Score> {
        self.judged(&sums.raw, &sums.along, &(&sums.by_unit - &self.q_by_unit * &sums.along))
    }

    /// The score from XᵀX, Q_1ᵀX and X̃ ∘ r̃ summed over each unit.
    pub fn judged<A, B>(
        &self,
        raw: &DMatrix<f64>,
        along: &Matrix<f64, Dyn, Dyn, A>,
        by_unit: &Matrix<f64, Dyn, Dyn, B>,
    ) -> Option<Score>
    where
        A: Storage<f64, Dyn, Dyn>,
        B: Storage<f64, Dyn, Dyn>,
    {
        let left = raw - cross(along, along);
        let total = raw.trace();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let basis = basis(raw, &left)?;
        let by_unit = by_unit * &basis;
        let freedom = basis.ncols();
        let squares: f64 = by_unit.column_iter().map(|column| column.sum().powi(2)).sum();
        let law = self.law(&by_unit);
        Some(Score {
            freedom,
            gain: self.gain(squares, self.rss),
            law,
            surprise: Surprise::of(self.gain(squares, self.rss), freedom, law.surprise(squares / self.rss)),
            share: left.trace() / total,
            by_unit: by_unit.map(|v| v as f32),
        })
    }
}

/// ‖r̃‖² less what is to be expected of ‖Q_1ᵀ S r̃‖².
fn flipped(residual: &DVector<f64>, q_by_unit: &DMatrix<f64>) -> f64 {
    let whole = residual.norm_squared();
    (whole - q_by_unit.norm_squared()).max(1e-3 * whole)
}

/// Σ over each unit's numbers of column × r̃.
fn by_unit(columns: &DMatrix<f64>, residual: &DVector<f64>, unit: &[usize], units: usize) -> DMatrix<f64> {
    let mut sums = DMatrix::zeros(units, columns.ncols());
    for (k, column) in columns.column_iter().enumerate() {
        let mut sum = sums.column_mut(k);
        for ((&unit, value), residual) in unit.iter().zip(column.iter()).zip(residual.iter()) {
            sum[unit] += value * residual;
        }
    }
    sums
}

/// T with `Tᵀ (left) T = 1`, over directions of which enough is left.
pub(crate) fn basis(raw: &DMatrix<f64>, left: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale: Vec<f64> =
        raw.diagonal().iter().map(|&v| if v > 0.0 { 1.0 / v.sqrt() } else { 0.0 }).collect();
    let k = scale.len();
    if k == 1 {
        let share = left[(0, 0)] * scale[0] * scale[0];
        return (share > ABSORBED).then(|| DMatrix::from_element(1, 1, scale[0] / share.sqrt()));
    }
    let scaled = DMatrix::from_fn(k, k, |i, j| left[(i, j)] * scale[i] * scale[j]);
    let eigen = SymmetricEigen::new(scaled);
    let kept: Vec<usize> = (0..k).filter(|&i| eigen.eigenvalues[i] > ABSORBED).collect();
    if kept.is_empty() {
        return None;
    }
    let mut basis = eigen.eigenvectors.select_columns(&kept);
    for (column, &i) in kept.iter().enumerate() {
        let length = eigen.eigenvalues[i].sqrt();
        for row in 0..k {
            basis[(row, column)] *= scale[row] / length;
        }
    }
    Some(basis)
}
