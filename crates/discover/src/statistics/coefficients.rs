//! The law from which the coefficients of a candidate look drawn, and what the candidate costs for having them.
//!
//! ```text
//! γ ~ N(0, w² I):   −2 ln p(y) = −2 ln L(γ̂) + C(w),   C(w) = Σ_k ln(1 + w² p_k) + g_k² p_k / (1 + w² p_k) − g_k² p_k / (1 + κ² p_k)
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | p, g | eigenvalues of the data's precision of γ, all other unknowns being free, and what the data says along them | 1 |
//! | κ | the wide prior under which γ̂ was found | expected sizes |
//! | w | where C is least (MacKay 1992) | expected sizes |
//!
//! A coefficient that the data knows a hundred times better than w costs 2 ln 100 and one; one that the data leaves open costs nothing:
//! a curve of twenty coefficients of which three are needed is not charged for twenty, as counting them would (Schwarz 1978). Only
//! curves and moving frames are charged so: where coefficients stand for separate causes, what the data leaves open is no virtue.

use crate::policy::WIDE;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use truepose_solvers::minimum;

/// ln w, between which w is looked for.
const NARROWEST: f64 = -9.0;
const WIDEST: f64 = 9.0;

/// A width and what it costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Law {
    /// w, expected sizes.
    pub width: f64,
    /// C(w).
    pub cost: f64,
}

impl Law {
    /// Of estimates with their covariance under the wide prior; of none there is nothing to say.
    pub fn of(coefficients: &DVector<f64>, covariance: &DMatrix<f64>) -> Self {
        if coefficients.is_empty() {
            return Law { width: 1.0, cost: 0.0 };
        }
        let eigen = SymmetricEigen::new(covariance.clone());
        let turned = eigen.eigenvectors.tr_mul(coefficients);
        // (p, g² p) of every direction that the data says anything about.
        let directions: Vec<(f64, f64)> = eigen
            .eigenvalues
            .iter()
            .zip(turned.iter())
            .filter_map(|(&variance, &value)| {
                let precision = 1.0 / variance.max(f64::MIN_POSITIVE) - WIDE.powi(-2);
                // Without the pull of the wide prior.
                let said = value / (variance * precision);
                (precision > 1e-3 * WIDE.powi(-2)).then_some((precision, said * said * precision))
            })
            .collect();
        let cost = |log: f64| -> f64 {
            let square = (2.0 * log).exp();
            let one = |&(p, t): &(f64, f64)| {
                let held = 1.0 + square * p;
                held.ln() + t / held - t / (1.0 + WIDE * WIDE * p)
            };
            directions.iter().map(one).sum()
        };
        let log = minimum(NARROWEST, WIDEST, cost);
        Law { width: log.exp(), cost: cost(log) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(values: &[f64], deviations: &[f64]) -> Law {
        let variances = deviations.iter().map(|d| 1.0 / (d.powi(-2) + WIDE.powi(-2)));
        let covariance = DMatrix::from_diagonal(&DVector::from_iterator(values.len(), variances));
        Law::of(&DVector::from_column_slice(values), &covariance)
    }

    #[test]
    fn what_the_data_leaves_open_neither_widens_nor_costs() {
        // Eight coefficients of ±3 that are known to 0.1, and two that are not known at all and came out at 70.
        let mut values: Vec<f64> = (0..8).map(|k| 3.0 * [1.0, -1.0][k % 2]).collect();
        let mut deviations = vec![0.1; 8];
        let few = law(&values, &deviations);
        assert!((few.width - 3.0).abs() < 0.01, "{}", few.width);
        // Each: ln(1 + 900) + 1, but for a trifle.
        assert!((few.cost - 8.0 * (901f64.ln() + 0.999)).abs() < 0.05, "{}", few.cost);
        values.extend([70.0, 70.0]);
        deviations.extend([1e5, 1e5]);
        let all = law(&values, &deviations);
        assert!((all.width - few.width).abs() < 0.01 && (all.cost - few.cost).abs() < 0.01);
    }

    #[test]
    fn what_is_not_there_costs_what_it_gains() {
        // Ten coefficients of one deviation each: nothing to pay for, nothing gained.
        assert_eq!(law(&[], &[]), Law { width: 1.0, cost: 0.0 });
        let nothing = law(&[0.1; 10], &[0.1; 10]);
        assert!(nothing.width < 1e-2 && (nothing.cost - 10.0).abs() < 0.1, "{nothing:?}");
    }
}
