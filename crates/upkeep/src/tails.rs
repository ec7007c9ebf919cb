//! Noise with tails: numbers far out count as numbers at the edge of the bulk, as Huber's ψ has it.
//!
//! ```text
//! ψ(v) = max(−c, min(c, v)),  c = 3 s,        r → ψ(r)/b,  H → a H/b,  P → a P/b,        a = E ψ',  b² = E ψ²
//! ```
//!
//! | symbol | here | |
//! | --- | --- | --- |
//! | v | residuals of the rows that the fit holds of its data, whitened by its noise; of each row what the unknowns took given back | 1 |
//! | s | their median of magnitudes over that of a standard normal number | 1 |
//! | f = Σ 2 n_v / Σ (z_v − n_v)² | z_v sum of n_v squares of ψ/b at a configuration; at most 1 | degrees of freedom of the law over numbers |
//!
//! A variance that a few numbers make is not that of the next ones: an unchanged robot whose noise has
//! tails was called changed too often. Of noise without tails nothing is changed. Source: Huber, *Robust Statistics* (1981), ch. 7.

use crate::UpkeepError;
use crate::prediction::Prediction;
use std::collections::BTreeMap;
use truepose_errormodel::{Dataset, FittedModel, configurations};

/// Edge of the bulk, in robust standard deviations. Convention.
const EDGE: f64 = 3.0;
/// Standard deviations of the kurtosis of as many normal numbers by which that of the residuals has to exceed three.
const HEAVY: f64 = 5.0;
/// Numbers below which a kurtosis is no evidence.
const FEWEST: usize = 60;

/// The noise of a fit, where it has tails.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tails {
    /// c.
    edge: f64,
    /// b.
    size: f64,
    /// a.
    slope: f64,
    /// f.
    pub freedom: f64,
}

impl Tails {
    /// Whitened numbers of the rows for one of [`Tails::bound`].
    pub fn unit(self) -> f64 {
        self.size / self.slope
    }
}

impl Tails {
    /// Of the rows that a fit holds of its data, in the installation of that data; `None` where their residuals have no tails, or are too few.
    pub fn of(fitted: &FittedModel) -> Result<Option<Self>, UpkeepError> {
        let rows = fitted.domain.sample.rows();
        if rows.is_empty() {
            return Ok(None);
        }
        // Each row by itself: a fit file does not state which of them were taken together, their joint values do.
        let single = Dataset { visit: (0..rows.len()).collect(), ..rows.clone() };
        let configuration = configurations(&single);
        let seen = Prediction::of(fitted, &[], &single)?;
        let v = &seen.residual;
        let n = v.len() as f64;
        let mean = |power: i32| v.iter().map(|v| v.powi(power)).sum::<f64>() / n;
        let square = mean(2);
        if v.len() < FEWEST || square <= 0.0 || mean(4) / square.powi(2) < 3.0 + HEAVY * (24.0 / n).sqrt() {
            return Ok(None);
        }
        let covariance = fitted.covariance();
        let known = (0..covariance.nrows()).filter(|&k| covariance[(k, k)] > 0.0).count() as f64;
        let drawn = fitted.domain.sample.drawn_from().max(rows.len()) as f64 * n / rows.len() as f64;
        let left = (1.0 - known / drawn).max(0.1);
        let mut sizes: Vec<f64> = v.iter().map(|v| v.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let edge = EDGE * sizes[sizes.len() / 2] / 0.674_49;
        if edge <= 0.0 {
            return Ok(None);
        }
        let bounded = |v: f64| v.clamp(-edge, edge);
        let size = (v.iter().map(|&v| bounded(v).powi(2)).sum::<f64>() / n / left).sqrt();
        let slope = v.iter().filter(|v| v.abs() < edge).count() as f64 / n;
        let mut sums = BTreeMap::<usize, (f64, f64)>::new();
        for (number, &v) in seen.numbers.iter().zip(v.iter()) {
            let sum = sums.entry(configuration[number.row]).or_default();
            *sum = (sum.0 + bounded(v).powi(2) / (size * size * left), sum.1 + 1.0);
        }
        let scatter: f64 = sums.values().map(|(sum, count)| (sum - count).powi(2)).sum();
        Ok(Some(Tails { edge, size, slope, freedom: (2.0 * n / scatter).min(1.0) }))
    }

    /// The rows with ψ in place of their residuals.
    pub fn bound(self, rows: &mut Prediction) {
        rows.residual.apply(|v| *v = v.clamp(-self.edge, self.edge) / self.size);
        rows.arm *= self.slope / self.size;
        rows.installation *= self.slope / self.size;
    }
}
