//! Whether an effect, as it was fitted, is one that nature has and the data shows.
//!
//! ```text
//! W = γᵀ C⁻¹ γ ~ χ²_k          γ the effect's coefficients in the fit, C their covariance, k how many there are
//! ```
//!
//! The contest judges candidates in the linearised problem; here the coefficients are those of the refitted model, with all other effects beside
//! them. Source of W: Wald (1943), as in Draper and Smith, *Applied Regression Analysis*, 3rd ed., §5.1.
//!
//! | family | what is refused | why |
//! | --- | --- | --- |
//! | any | a coefficient outside of its column's bounds by more than its 95 % interval | a gap and a compliance are not negative: the link lags behind its motor, what yields, yields with its load |
//! | backlash, transmission | a coefficient above 10 mrad | five times the worn gears of the literature (1–2 mrad): a mistake of the description |
//! | coupling | more than 10 mrad of this joint for a radian of the other | belts and wrist gears couple by parts in a thousand once their ratio is declared |

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use nalgebra::DVector;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::ops::Range;
use truepose_identify::{Fit, Warning};

/// Probability above which the coefficients of a finding are taken for zero. The search has its own, family-wise one; this is a single test.
const SIGNIFICANT: f64 = 0.01;
/// The largest angle of a joint that a drive is believed to err by, rad, or rad for each rad of the joint that drags it.
const LARGEST_ANGLE: f64 = 1e-2;

/// What speaks against an effect as it was fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Objection {
    /// Its coefficients are not significant.
    NotSignificant,
    /// Their sign or size is none that nature has.
    NotPhysical,
}

/// Judges a finding whose effects have these numbers in the model of a fit. A corrected load has no effects and is judged by its own deviation.
pub(crate) fn objection(fit: &Fit, found: &Candidate, effects: Range<usize>) -> Option<Objection> {
    let model = fit.fitted.model();
    let columns: Vec<usize> = effects
        .flat_map(|effect| model.columns_of(effect))
        .filter(|column| fit.reduction.kept.contains(column))
        .collect();
    if columns.is_empty() {
        return None;
    }
    let covariance = fit.fitted.covariance();
    let values = DVector::from_iterator(columns.len(), columns.iter().map(|&k| fit.fitted.coefficients()[k]));
    let name = |k: usize| &model.columns()[columns[k]].name;
    let unit = |k: usize| model.columns()[columns[k]].unit.as_str();
    let out_of_bounds = fit.warnings.iter().any(|warning| match warning {
        Warning::OutOfBounds { column, .. } => (0..columns.len()).any(|k| name(k) == column),
        _ => false,
    });
    let bounded = matches!(found.family, Family::Backlash | Family::Transmission | Family::Coupling);
    let too_large = |k: usize| matches!(unit(k), "rad" | "rad/rad") && values[k].abs() > LARGEST_ANGLE;
    if out_of_bounds || (bounded && (0..columns.len()).any(too_large)) {
        return Some(Objection::NotPhysical);
    }
    let own = covariance.select_rows(&columns).select_columns(&columns);
    is_nothing(&values, own).then_some(Objection::NotSignificant)
}

/// Whether all coefficients together may be zero.
fn is_nothing(values: &DVector<f64>, covariance: nalgebra::DMatrix<f64>) -> bool {
    // In standard deviations: the units of the columns differ by many powers of ten.
    let sizes: DVector<f64> = covariance.diagonal().map(|v| v.max(f64::MIN_POSITIVE).sqrt());
    let scaled = DVector::from_fn(values.len(), |k, _| values[k] / sizes[k]);
    let correlation = nalgebra::DMatrix::from_fn(values.len(), values.len(), |i, j| {
        covariance[(i, j)] / (sizes[i] * sizes[j]) + if i == j { 1e-9 } else { 0.0 }
    });
    let Some(factor) = correlation.cholesky() else { return false };
    let statistic = scaled.dot(&factor.solve(&scaled));
    ChiSquared::new(values.len() as f64).is_ok_and(|law| law.sf(statistic) > SIGNIFICANT)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn coefficients_within_their_intervals_may_still_be_significant_together() {
        let values = DVector::from_vec(vec![1.5, 1.5]);
        assert!(is_nothing(&values, DMatrix::identity(2, 2)));
        // Of a sum that is known ten times better than each of them.
        let together = DMatrix::from_row_slice(2, 2, &[1.0, -0.98, -0.98, 1.0]);
        assert!(!is_nothing(&values, together));
        assert!(is_nothing(&DVector::from_vec(vec![1e-9]), DMatrix::from_element(1, 1, 1e-18)));
    }
}
