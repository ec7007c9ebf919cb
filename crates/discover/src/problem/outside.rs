//! Which of many squared distances lie outside: rows or poses, each with its t².
//!
//! The scale is the median's, the heaviness of the tail is that of the bulk: `t²/3 ~ F(3, ν)`, ν from the ratio of the 95 % quantile to the
//! median. What is reported has to lie outside even if the tail is two standard errors of that ratio heavier than it looks: a handful of
//! visits says little about a tail. So a robot with heavy-tailed noise has no outliers, and one whose noise is normal has them from five
//! deviations on. Several of them hide each other that way, for they make the tail; so they are also reported where a law of their own beside
//! the bulk is far more likely than any tail ([`crate::statistics::gross`]).

use crate::policy::Policy;
use crate::statistics::chi_square::surprisal;
use crate::statistics::gross::{SquareDistribution, split};
use statrs::distribution::{ContinuousCDF, Exp};

/// Rows or poses (unit, t²) of which anything was measured, t² as of three components.
pub(crate) fn units(sums: Vec<(f64, usize)>) -> Vec<(usize, f64)> {
    let of_three = |(square, count): (f64, usize)| match count {
        3 => square,
        _ => {
            let wanted = surprisal(square, count);
            let (mut low, mut high) = (square, square + 40.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if surprisal(middle, 3) < wanted { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        }
    };
    let measured =
        sums.into_iter().enumerate().filter(|(_, (square, count))| *count > 0 && square.is_finite());
    measured.map(|(unit, sum)| (unit, of_three(sum))).collect()
}

/// Units that lie outside.
#[derive(Default)]
pub(crate) struct Judged {
    /// Ascending.
    pub suspects: Vec<usize>,
    /// With the number of good units that would be expected as far out.
    pub certain: Vec<(usize, f64)>,
    /// In robust deviations of one axis.
    pub distances: Vec<(usize, f64)>,
}

/// Judges units (unit, t²) of so many visits: rows of one visit are not independent.
pub(crate) fn judged(units: &[(usize, f64)], visits: usize, policy: &Policy) -> Judged {
    let mut found = Judged::default();
    let by_unit: Vec<f64> = units.iter().map(|unit| unit.1).collect();
    if by_unit.len() < 20 {
        return found;
    }
    let mut whole = by_unit.clone();
    whole.sort_by(f64::total_cmp);
    let at = |share: f64| whole[((whole.len() - 1) as f64 * share).round() as usize];
    let ratio = at(0.95) / at(0.5).max(f64::MIN_POSITIVE);
    let distribution = SquareDistribution::new(tail(ratio));
    let scale_under = |distribution: &SquareDistribution| {
        (at(0.5) / (3.0 * distribution.quantile(0.5))).max(f64::MIN_POSITIVE)
    };
    let scale = scale_under(&distribution);
    let expected = |square: f64| whole.len() as f64 * distribution.above(square / (3.0 * scale));
    let heavier = SquareDistribution::new(tail(
        ratio * (2.0 * policy.outlier_ratio_error / (visits.max(1) as f64).sqrt()).exp(),
    ));
    let scale_then = scale_under(&heavier);
    let expected_then = |square: f64| whole.len() as f64 * heavier.above(square / (3.0 * scale_then));
    for &(unit, square) in units {
        found.distances.push((unit, (square / scale / 3.0).sqrt()));
        if square > 3.0 * policy.outlier_least * policy.outlier_least * scale / 3.0 {
            if expected(square) < policy.outlier_suspect {
                found.suspects.push(unit);
            }
            let expected = expected_then(square);
            if expected < policy.outlier_certain {
                found.certain.push((unit, expected));
            }
        }
    }
    let gross =
        split(&by_unit, scale_under, policy.outlier_least * policy.outlier_least, policy.outlier_most);
    // Rows of one visit may share what sets them apart: no more than as many are independent as there are visits.
    let independent = (visits as f64 / whole.len() as f64).min(1.0);
    let p_value = chance(gross.gain * independent);
    if p_value < policy.outlier_certain {
        for (&(unit, _), &odds) in units.iter().zip(&gross.odds) {
            if odds > 1.0 && !found.suspects.contains(&unit) {
                found.suspects.push(unit);
            }
            if odds > policy.outlier_odds && !found.certain.iter().any(|c| c.0 == unit) {
                found.certain.push((unit, p_value));
            }
        }
    }
    if found.suspects.len() as f64 > policy.outlier_most * whole.len() as f64 {
        found.suspects.clear();
        found.certain.clear();
    }
    found.suspects.sort_unstable();
    found
}

/// By chance twice the logarithm of a likelihood ratio with two more unknowns is this large: χ²_2 is exponential.
fn chance(gain: f64) -> f64 {
    Exp::new(0.5).map_or(1.0, |distribution| distribution.sf(gain))
}

/// ν at which the 95 % quantile over the median is this; 100 and more is normal.
fn tail(ratio: f64) -> f64 {
    let of = |freedom: f64| {
        let distribution = SquareDistribution::new(freedom);
        distribution.quantile(0.95) / distribution.quantile(0.5)
    };
    if ratio.is_nan() || ratio <= of(100.0) {
        return 100.0;
    }
    let (mut low, mut high) = (2.0, 100.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if of(middle) > ratio { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
