//! Single rows that no repeatable effect explains.
//!
//! Each row is standardised by what all others of its visit say; `t² = Σ e²` of its position has three degrees of freedom. The
//! scale is the median's, the heaviness of the tail is that of the bulk: `t²/3 ~ F(3, ν)`, ν from the ratio of the
//! 95 % quantile to the median. What is reported has to lie outside even if the tail is two standard errors of that ratio heavier than it
//! looks: a handful of visits says little about a tail. So a robot with heavy-tailed noise has no outliers, and one whose noise is normal has them
//! from five deviations on. Several of them hide each other that way, for they make the tail; so they are also reported where
//! a law of their own beside the bulk is far more likely than any tail ([`crate::statistics::gross`]).

use crate::problem::linearisation::Scene;
use crate::statistics::gross::{Law, split};
use statrs::distribution::{ContinuousCDF, Exp};
use truepose_identify::NoiseModel;

/// Rows that lie outside.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Outliers {
    /// Rows that are kept out of fits.
    pub suspects: Vec<usize>,
    /// Rows that are reported.
    pub certain: Vec<usize>,
    /// How many good rows would be expected beyond the least of those: the family-wise p; 1 without any.
    pub p_value: f64,
    /// Standardised distance of every row of the data, in robust deviations of one axis; NaN where nothing was measured.
    pub distance: Vec<f64>,
}

/// Expected number of good rows that would be kept out, and reported.
const SUSPECT: f64 = 0.05;
const CERTAIN: f64 = 0.002;
/// Odds from which on a row is gross rather than one of the tail's.
const SURE: f64 = 99.0;
/// Standard error of the logarithm of the ratio of quantiles, times √visits: of order statistics of a χ²_3.
const RATIO_ERROR: f64 = 1.4;
/// Nothing below so many robust deviations is an outlier.
const LEAST: f64 = 5.0;
/// At most this share of the rows: more are no outliers, but an effect.
const MOST: f64 = 0.15;

/// Judges the rows of a scene by these raw residuals.
pub(crate) fn outliers(scene: &Scene<'_>, residual: &[f64], noise: NoiseModel) -> Outliers {
    let standardised = scene.whitener(noise).deleted(residual);
    let mut squares = vec![f64::NAN; scene.data.len()];
    let mut counts = vec![0usize; scene.data.len()];
    for (o, e) in scene.observations.iter().zip(&standardised) {
        if o.component < 3 {
            squares[o.row] = if counts[o.row] == 0 { e * e } else { squares[o.row] + e * e };
            counts[o.row] += 1;
        }
    }
    let of_rows: Vec<usize> =
        (0..squares.len()).filter(|&row| counts[row] == 3 && squares[row].is_finite()).collect();
    let mut whole: Vec<f64> = of_rows.iter().map(|&row| squares[row]).collect();
    let mut found = Outliers { distance: vec![f64::NAN; scene.data.len()], ..Outliers::default() };
    if whole.len() < 20 {
        return found;
    }
    let by_row = whole.clone();
    whole.sort_by(f64::total_cmp);
    let at = |share: f64| whole[((whole.len() - 1) as f64 * share).round() as usize];
    let ratio = at(0.95) / at(0.5).max(f64::MIN_POSITIVE);
    let law = Law::new(tail(ratio));
    let scale_under = |law: &Law| (at(0.5) / (3.0 * law.quantile(0.5))).max(f64::MIN_POSITIVE);
    let scale = scale_under(&law);
    let expected = |square: f64| whole.len() as f64 * law.above(square / (3.0 * scale));
    let heavier = Law::new(tail(ratio * (2.0 * RATIO_ERROR / (scene.visits.max(1) as f64).sqrt()).exp()));
    let scale_then = scale_under(&heavier);
    let expected_then = |square: f64| whole.len() as f64 * heavier.above(square / (3.0 * scale_then));
    for (row, (&square, &count)) in squares.iter().zip(&counts).enumerate() {
        if count != 3 {
            continue;
        }
        found.distance[row] = (square / scale / 3.0).sqrt();
        if square > 3.0 * LEAST * LEAST * scale / 3.0 {
            if expected(square) < SUSPECT {
                found.suspects.push(row);
            }
            let expected = expected_then(square);
            if expected < CERTAIN {
                found.certain.push(row);
                found.p_value = found.p_value.max(expected);
            }
        }
    }
    let gross = split(&by_row, scale_under, LEAST * LEAST);
    // Rows of one visit may share what sets them apart: no more than as many are independent as there are visits.
    let independent = (scene.visits as f64 / whole.len() as f64).min(1.0);
    let p_value = chance(gross.gain * independent);
    if p_value < CERTAIN {
        for (&row, &odds) in of_rows.iter().zip(&gross.odds) {
            if odds > 1.0 && !found.suspects.contains(&row) {
                found.suspects.push(row);
            }
            if odds > SURE && !found.certain.contains(&row) {
                found.certain.push(row);
                found.p_value = found.p_value.max(p_value);
            }
        }
        found.suspects.sort_unstable();
        found.certain.sort_unstable();
    }
    if found.certain.is_empty() {
        found.p_value = 1.0;
    }
    if found.suspects.len() as f64 > MOST * whole.len() as f64 {
        found.suspects.clear();
        found.certain.clear();
    }
    found
}

/// By chance twice the logarithm of a likelihood ratio with two more unknowns is this large: χ²_2 is exponential.
fn chance(gain: f64) -> f64 {
    Exp::new(0.5).map_or(1.0, |law| law.sf(gain))
}

/// ν at which the 95 % quantile over the median is this; 100 and more is normal.
fn tail(ratio: f64) -> f64 {
    let of = |freedom: f64| {
        let law = Law::new(freedom);
        law.quantile(0.95) / law.quantile(0.5)
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
