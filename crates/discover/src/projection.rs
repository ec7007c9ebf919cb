//! What the present model leaves, and candidates with everything that it explains projected out.
//!
//! ```text
//! [A; W] = [Q_1; Q_2] R,   r̃ = y − Q_1 Q_1ᵀ y,   X̃ = X − Q_1 Q_1ᵀ X,   X̃ᵀX̃ (with the prior's rows) = XᵀX − (Q_1ᵀX)ᵀ Q_1ᵀX
//! ```
//!
//! all whitened. With an orthonormal basis T of the projected candidate, `SS = ‖Tᵀ Xᵀ r̃‖²` is what it would take from
//! the sum of squares RSS (score test, no refit), and `LR = −m ln(1 − SS/RSS)`. Statistics of different numbers of
//! unknowns are compared on the scale of a normal quantile (Wilson and Hilferty 1931). A direction of which the present model already
//! explains nearly all is left out: there the data cannot speak for the candidate.

use crate::product::cross;
use crate::scene::Scene;
use crate::whitener::Whitener;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Directions of which less than this share is left are absorbed by the present model.
const ABSORBED: f64 = 2e-3;

/// The present model, projected out.
pub(crate) struct Projection {
    pub whitener: Whitener,
    /// Q_1, m × r.
    pub q: DMatrix<f64>,
    /// r̃, m.
    pub residual: DVector<f64>,
    /// ‖r̃‖² with the prior's rows.
    pub rss: f64,
    /// The exchangeable unit of each number, and how many there are.
    pub unit: Vec<usize>,
    pub units: usize,
}

/// How a candidate does against what is left.
#[derive(Debug, Clone)]
pub(crate) struct Score {
    /// Directions that the data can judge.
    pub freedom: usize,
    /// −m ln(1 − SS/RSS).
    pub gain: f64,
    /// Normal quantile of the gain.
    pub quantile: f64,
    /// Share of the candidate that the present model does not absorb, ‖X̃‖²/‖X‖².
    pub share: f64,
    /// Scores of the units along the orthonormal basis, units × freedom.
    pub by_unit: DMatrix<f32>,
}

/// More units than this are merged, neighbours in time together.
const MOST_UNITS: usize = 400;

impl Projection {
    pub fn new(scene: &Scene<'_>) -> Self {
        Projection::with(scene, &DMatrix::zeros(scene.len(), 0))
    }

    /// With further raw columns (m × k) in the present model.
    pub fn with(scene: &Scene<'_>, more: &DMatrix<f64>) -> Self {
        let whitener = Whitener::new(scene, scene.noise);
        let known = scene.base.ncols();
        let mut a = scene.base.clone().resize_horizontally(known + more.ncols(), 0.0);
        a.columns_mut(known, more.ncols()).copy_from(more);
        whitener.apply(&mut a);
        let y = whitener.of(&DMatrix::from_column_slice(scene.len(), 1, scene.y.as_slice()));
        let (m, r) = a.shape();
        let extra = scene.prior.as_ref().map_or(0, DMatrix::nrows);
        let mut joined = DMatrix::zeros(m + extra, r);
        joined.rows_mut(0, m).copy_from(&a);
        if let Some(prior) = &scene.prior {
            joined.view_mut((m, 0), (extra, known)).copy_from(prior);
        }
        let q = if r == 0 { joined } else { joined.qr().q() };
        let (top, bottom) = (q.rows(0, m).into_owned(), q.rows(m, extra).into_owned());
        let along = cross(&top, &y).column(0).into_owned();
        let residual = y.column(0) - &top * &along;
        let rss = residual.norm_squared() + (&bottom * &along).norm_squared();
        let merge = scene.visits.div_ceil(MOST_UNITS).max(1);
        let unit: Vec<usize> = scene.observations.iter().map(|o| o.visit / merge).collect();
        Projection { whitener, q: top, residual, rss, units: scene.visits.div_ceil(merge), unit }
    }

    /// How many numbers were measured.
    pub fn len(&self) -> usize {
        self.residual.len()
    }

    /// −m ln(1 − SS/RSS).
    pub fn gain(&self, squares: f64, rss: f64) -> f64 {
        -(self.len() as f64) * (1.0 - (squares / rss).min(1.0 - 1e-12)).ln()
    }

    /// The score of a candidate's raw columns; none when nothing of it is left.
    pub fn score(&self, columns: &DMatrix<f64>) -> Option<Score> {
        let x = self.whitener.of(columns);
        let along = cross(&self.q, &x);
        let raw = cross(&x, &x);
        let left = &raw - cross(&along, &along);
        let total = raw.trace();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let basis = basis(&raw, &left)?;
        let projected = (&x - &self.q * &along) * &basis;
        let by_unit = self.by_unit(&projected);
        let freedom = basis.ncols();
        let squares: f64 = (0..freedom).map(|k| by_unit.column(k).sum().powi(2)).sum();
        let gain = self.gain(squares, self.rss);
        Some(Score {
            freedom,
            gain,
            quantile: quantile(gain, freedom),
            share: left.trace() / total,
            by_unit: by_unit.map(|v| v as f32),
        })
    }

    /// Σ over each unit's numbers of column × r̃.
    pub fn by_unit(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut sums = DMatrix::zeros(self.units, columns.ncols());
        for (k, column) in columns.column_iter().enumerate() {
            let mut sum = sums.column_mut(k);
            for ((&unit, value), residual) in self.unit.iter().zip(column.iter()).zip(self.residual.iter()) {
                sum[unit] += value * residual;
            }
        }
        sums
    }
}

/// T with `Tᵀ (left) T = 1`, over directions of which enough is left.
pub(crate) fn basis(raw: &DMatrix<f64>, left: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale: Vec<f64> =
        raw.diagonal().iter().map(|&v| if v > 0.0 { 1.0 / v.sqrt() } else { 0.0 }).collect();
    let k = scale.len();
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

/// The normal quantile of a χ² of so many degrees of freedom (Wilson and Hilferty): never out of range.
pub(crate) fn quantile(chi_square: f64, freedom: usize) -> f64 {
    let k = freedom.max(1) as f64;
    let spread = 2.0 / (9.0 * k);
    ((chi_square.max(0.0) / k).cbrt() - (1.0 - spread)) / spread.sqrt()
}
