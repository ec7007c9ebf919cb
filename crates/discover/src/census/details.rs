//! A candidate beside the model, on all rows.

use crate::census::all_rows::AllRows;
use crate::policy::Policy;
use crate::problem::basis::basis;
use crate::problem::tables::Sums;
use crate::statistics::beta::surprisal;
use crate::statistics::coefficients::CoefficientDistribution;
use nalgebra::{DMatrix, DVector};

/// What all rows say of a candidate.
#[derive(Debug, Clone)]
pub(crate) struct Detail {
    /// Z = (Σ AᵀA + WᵀW)⁻¹ Σ AᵀX, r × k: what the model takes of the candidate.
    pub taken: DMatrix<f64>,
    /// T, k × freedom.
    pub basis: DMatrix<f64>,
    /// −m ln(1 − SS/RSS).
    pub gain: f64,
    pub surprisal: f64,
    /// Coefficients in expected sizes under a wide prior, k, with the standard deviation of the first.
    pub coefficients: DVector<f64>,
    pub first_deviation: f64,
    pub distribution: CoefficientDistribution,
}

impl Detail {
    /// From sums over every `stride`-th block; none where nothing of the candidate is left.
    pub fn of(sums: &Sums, all: &AllRows, stride: usize, policy: &Policy) -> Option<Self> {
        let times = stride.max(1) as f64;
        let (raw, along, score) = (&sums.raw * times, &sums.along * times, &sums.score * times);
        let taken = &all.inverse * &along;
        let left = &raw - along.tr_mul(&taken);
        let total = raw.trace();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let basis = basis(&raw, &left, policy.absorbed)?;
        let held = &left + DMatrix::identity(left.nrows(), left.nrows()) * policy.wide.powi(-2);
        let covariance = held.cholesky()?.inverse();
        let coefficients = &covariance * &score;
        let turned = basis.tr_mul(&score);
        let rows = all.count as f64;
        let fraction = (turned.norm_squared() / all.squares).min(1.0 - 1e-12);
        let freedom = all.count.saturating_sub(all.inverse.nrows());
        Some(Detail {
            gain: -rows * (1.0 - fraction).ln(),
            surprisal: surprisal(fraction, basis.ncols(), freedom),
            distribution: CoefficientDistribution::of(&coefficients, &covariance, policy.wide),
            first_deviation: covariance[(0, 0)].sqrt(),
            coefficients,
            basis,
            taken,
        })
    }

    /// Directions that the data can judge.
    pub fn freedom(&self) -> usize {
        self.basis.ncols()
    }
}
