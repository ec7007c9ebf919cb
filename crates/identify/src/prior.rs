//! A prior on the grouped errors that does not depend on which members of a group were kept.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | s | expected sizes of all columns | p | each its own |
//! | G | grouping, β = G c: 1 at the kept column, −c_j at what passes into it | r × p | |
//! | κ | `kappa` | 1 | 1 |
//! | Σ = κ² G S² Gᵀ | prior covariance of β | r × r | |
//! | R Σ₁^{1/2} = U diag(d) Vᵀ | whitened data in prior units (κ = 1) | r × r | 1 |
//!
//! κ comes from the data, by the marginal likelihood of `t = Uᵀ z ~ N(0, 1 + κ² d²)`:
//! `min_κ Σ_k ln(1 + κ² d_k²) + t_k² / (1 + κ² d_k²)` (Robbins 1956; MacKay 1992; here in the form for ridge
//! regression). Directions with κ d ≫ 1 are untouched: for them the fit is least squares.

use crate::IdentifyError;
use crate::reduction::Reduction;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::ErrorModel;
use truepose_solvers::accumulator::{ColumnScale, Factor, Triangular};

/// How strongly coefficients are held to their expected sizes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PriorStrength {
    /// Not at all: plain least squares.
    None,
    /// Standard deviations of κ expected sizes.
    Fixed(f64),
    /// κ from the data, by marginal likelihood.
    Evidence,
}

/// A prior for the kept columns: rows `W (β + δ) = 0` with `WᵀW = Σ⁻¹`.
#[derive(Debug, Clone, PartialEq)]
pub struct Prior {
    /// L⁻¹ of `G S² Gᵀ = L Lᵀ`, r × r, for κ = 1.
    unit: DMatrix<f64>,
    /// L.
    spread: DMatrix<f64>,
    /// κ; infinite without a prior.
    pub kappa: f64,
}

impl Prior {
    /// No prior, before there is a reduction.
    pub(crate) fn none() -> Self {
        Prior { unit: DMatrix::zeros(0, 0), spread: DMatrix::zeros(0, 0), kappa: f64::INFINITY }
    }

    /// The prior over a reduction's groups, with κ still at its start.
    pub fn new(model: &ErrorModel, reduction: &Reduction, strength: PriorStrength) -> Self {
        let rank = reduction.rank();
        let kappa = match strength {
            PriorStrength::None => f64::INFINITY,
            PriorStrength::Fixed(kappa) => kappa,
            PriorStrength::Evidence => START,
        };
        let scale = |c: usize| model.columns()[c].scale;
        // G S, scaled by the kept columns' sizes so that the Cholesky factor is well conditioned.
        let mut grouped = DMatrix::zeros(rank, model.columns().len());
        for (row, group) in reduction.groups.iter().enumerate() {
            grouped[(row, group.column)] = 1.0;
            for &(column, coefficient) in &group.members {
                grouped[(row, column)] = coefficient * scale(column) / scale(group.column);
            }
        }
        let covariance = &grouped * grouped.transpose();
        let mut spread = covariance.cholesky().map_or_else(|| DMatrix::identity(rank, rank), |c| c.unpack());
        let mut unit = spread
            .solve_lower_triangular(&DMatrix::identity(rank, rank))
            .unwrap_or_else(|| DMatrix::identity(rank, rank));
        for (k, group) in reduction.groups.iter().enumerate() {
            unit.column_mut(k).scale_mut(1.0 / scale(group.column));
            spread.row_mut(k).scale_mut(scale(group.column));
        }
        Prior { unit, spread, kappa }
    }

    /// W, r × r; none without a prior.
    pub fn rows(&self) -> Option<DMatrix<f64>> {
        self.kappa.is_finite().then(|| &self.unit / self.kappa)
    }

    /// W for κ = 1, whatever κ is: what "an expected size" means for each direction.
    pub fn unit_rows(&self) -> &DMatrix<f64> {
        &self.unit
    }

    /// ‖W β‖².
    pub fn penalty(&self, grouped: &[f64]) -> f64 {
        if !self.kappa.is_finite() {
            return 0.0;
        }
        (&self.unit * DVector::from_column_slice(grouped)).norm_squared() / (self.kappa * self.kappa)
    }

    /// The most likely grouped errors when coarser groups `G β` have these values: `Σ Gᵀ (G Σ Gᵀ)⁻¹ values`; none where those
    /// groups are not independent.
    pub(crate) fn shared_out(&self, groups: &DMatrix<f64>, values: &[f64]) -> Option<DVector<f64>> {
        let spread = groups * &self.spread;
        let covariance = &spread * spread.transpose();
        let pulled = covariance.cholesky()?.solve(&DVector::from_column_slice(values));
        Some(&self.spread * spread.tr_mul(&pulled))
    }

    /// The factor with the prior's rows, given that its unknowns are `β − at` (zero for absolute ones).
    ///
    /// # Errors
    /// When a factorisation fails.
    pub fn joined(&self, factor: &Factor, at: &[f64]) -> Result<Factor, IdentifyError> {
        let Some(rows) = self.rows() else { return Ok(factor.clone()) };
        let pull = -(&rows * DVector::from_column_slice(at));
        let mut all = Triangular::new(factor.columns(), 1);
        all.update(&factor.r, &factor.z)?;
        all.update(&rows, &DMatrix::from_column_slice(pull.len(), 1, pull.as_slice()))?;
        let mut joined = all.finish();
        joined.rss[0] += factor.rss[0];
        Ok(joined)
    }

    /// With κ from the data: `factor` is whitened, over the kept columns, with absolute coefficients on its right.
    ///
    /// # Errors
    /// When a factorisation fails.
    pub fn from_evidence(&self, factor: &Factor) -> Result<Self, IdentifyError> {
        // R L: columns of data in prior units.
        let mut inner = factor.clone();
        inner.r = &factor.r * &self.spread;
        let turned = inner.directions(ColumnScale::Unit)?;
        let pairs: Vec<(f64, f64)> =
            turned.values.iter().zip(&turned.projections).map(|(d, t)| (d * d, t * t)).collect();
        let deviance = |log_kappa: f64| -> f64 {
            let square = (2.0 * log_kappa).exp();
            // Logarithms of products: of so many factors that none is beyond what a number can hold.
            pairs
                .chunks(8)
                .map(|some| {
                    let (mut product, mut sum) = (1.0, 0.0);
                    for (d, t) in some {
                        let variance = 1.0 + square * d;
                        product *= variance;
                        sum += t / variance;
                    }
                    if product.is_finite() { product.ln() + sum } else { exact(some, square) }
                })
                .sum()
        };
        Ok(Prior { kappa: minimum(LEAST.ln(), MOST.ln(), deviance).exp(), ..self.clone() })
    }
}

/// Minus twice the logarithm of some directions' evidence, factor by factor.
fn exact(pairs: &[(f64, f64)], square: f64) -> f64 {
    pairs.iter().map(|(d, t)| (1.0 + square * d).ln() + t / (1.0 + square * d)).sum()
}

/// κ before the data has been looked at, and the range in which it is looked for.
const START: f64 = 30.0;
const LEAST: f64 = 0.1;
const MOST: f64 = 1e4;

/// Minimum of a function with few wiggles: a coarse scan, then golden sections around its best point.
fn minimum(lower: f64, upper: f64, f: impl Fn(f64) -> f64) -> f64 {
    const SCAN: usize = 60;
    let at = |k: usize| lower + (upper - lower) * k as f64 / SCAN as f64;
    let best = (0..=SCAN).fold(0, |best, k| if f(at(k)) < f(at(best)) { k } else { best });
    let (mut a, mut b) = (at(best.saturating_sub(1)), at((best + 1).min(SCAN)));
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..50 {
        let (c, d) = (b - golden * (b - a), a + golden * (b - a));
        if f(c) < f(d) { b = d } else { a = c }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::effects::Geometric;
    use truepose_kinematics::samples;

    fn prior() -> (Prior, usize) {
        let chain = samples::scara();
        let model = ErrorModel::new(chain, vec![Box::new(Geometric::default())]).unwrap();
        let reduction = Reduction::none(model.columns().len());
        (Prior::new(&model, &reduction, PriorStrength::Evidence), model.columns().len())
    }

    #[test]
    fn evidence_finds_the_size_that_was_drawn() {
        let (prior, n) = prior();
        // Coefficients of 5 expected sizes each, alternately; data that determines them 100 times better.
        let spread = prior.unit.clone().try_inverse().unwrap();
        let truth = &spread * DVector::from_fn(n, |k, _| if k % 2 == 0 { 5.0 } else { -5.0 });
        let mut data = Triangular::new(n, 1);
        let a = &prior.unit * 20.0;
        let y = &a * &truth;
        data.update(&a, &DMatrix::from_column_slice(n, 1, y.as_slice())).unwrap();
        let kappa = prior.from_evidence(&data.finish()).unwrap().kappa;
        assert!((kappa - 5.0).abs() < 0.05, "{kappa}");
    }

    #[test]
    fn groups_are_shared_out_as_their_members_sizes_say() {
        let (prior, n) = prior();
        // The first group is the sum of the first two errors; all others stand alone.
        let groups =
            DMatrix::from_fn(
                n - 1,
                n,
                |i, j| {
                    if (i == 0 && j < 2) || (i > 0 && j == i + 1) { 1.0 } else { 0.0 }
                },
            );
        let values: Vec<f64> = (0..n - 1).map(|k| 1e-3 * (k as f64 + 1.0)).collect();
        let shared = prior.shared_out(&groups, &values).unwrap();
        let variance = |k: usize| (&prior.spread * prior.spread.transpose())[(k, k)];
        let share = variance(0) / (variance(0) + variance(1));
        assert!((shared[0] - share * values[0]).abs() < 1e-12 && (&groups * &shared)[0] - values[0] < 1e-15);
        assert!((2..n).all(|k| (shared[k] - values[k - 1]).abs() < 1e-12));
    }

    #[test]
    fn without_a_prior_nothing_is_joined() {
        let chain = samples::scara();
        let model = ErrorModel::new(chain, vec![Box::new(Geometric::default())]).unwrap();
        let reduction = Reduction::none(model.columns().len());
        let prior = Prior::new(&model, &reduction, PriorStrength::None);
        assert!(prior.rows().is_none());
        assert!(prior.penalty(&vec![1.0; reduction.rank()]) < f64::MIN_POSITIVE);
    }
}
