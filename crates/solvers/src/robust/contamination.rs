//! Whether visits are wrong: the likelihood of a contaminated normal distribution against that of a normal one.
//!
//! p(e) = (1 − ε) N(0, σ² V) + ε N(0, κ² σ² V),  ε ≤ ½, κ ≥ 1
//!
//! | symbol | name | unit |
//! | --- | --- | --- |
//! | e, V | residuals of a visit by the fit of all others, and their covariance over σ² | 1 |
//! | ε | fraction of the visits that are wrong | 1 |
//! | κ | standard deviation of a wrong visit over that of a right one | 1 |
//!
//! Both are densities of what the fit did not see, so that fits can be compared by them as well: the logarithmic score (Gneiting and Raftery
//! 2007). Two more parameters cost ln G for G visits (Schwarz 1978). Source of the distribution: Tukey (1960); of its fit: Dempster, Laird
//! and Rubin (1977).

use super::left_out::LeftOut;

/// Log-likelihood of a normal distribution at its best σ, without the constant −½ N ln 2π.
pub(super) fn normal(visits: &[LeftOut]) -> f64 {
    let (rows, squares) = totals(visits);
    -0.5 * (determinants(visits) + rows * (squares / rows).max(f64::MIN_POSITIVE).ln() + rows)
}

/// Log-likelihood of a contaminated normal distribution at its best σ, ε and κ, less the ln G that two more parameters cost.
pub(super) fn contaminated(visits: &[LeftOut]) -> f64 {
    /// Where the search begins: a few grossly wrong visits, or a tenth that is moderately wrong.
    const BEGINNINGS: [(f64, f64); 2] = [(0.02, 400.0), (0.1, 16.0)];
    let best = BEGINNINGS.iter().map(|&start| maximise(visits, start)).fold(f64::NEG_INFINITY, f64::max);
    best - 0.5 * determinants(visits) - (visits.len().max(1) as f64).ln()
}

fn totals(visits: &[LeftOut]) -> (f64, f64) {
    let rows: usize = visits.iter().map(|v| v.rows).sum();
    (rows.max(1) as f64, visits.iter().map(|v| v.square).sum())
}

fn determinants(visits: &[LeftOut]) -> f64 {
    visits.iter().map(|v| v.log_determinant).sum()
}

/// Expectation and maximisation from a fraction and a κ²; the log-likelihood without the determinants.
fn maximise(visits: &[LeftOut], (mut fraction, mut ratio): (f64, f64)) -> f64 {
    const ITERATIONS: usize = 300;
    const TOLERANCE: f64 = 1e-6;
    let (rows, squares) = totals(visits);
    // What is left of the squares when wrong visits have their share of them.
    let mut variance = squares / rows / (1.0 + fraction * (ratio - 1.0));
    let mut best = f64::NEG_INFINITY;
    for _ in 0..ITERATIONS {
        let (mut likelihood, mut wrong, mut right_squares, mut wrong_squares) = (0.0, 0.0, 0.0, 0.0);
        let (mut right_rows, mut wrong_rows) = (0.0, 0.0);
        variance = variance.max(f64::MIN_POSITIVE);
        for visit in visits {
            let n = visit.rows as f64;
            let log = |part: f64, variance: f64| {
                part.ln() - 0.5 * n * variance.ln() - 0.5 * visit.square / variance
            };
            let (right, other) = (log(1.0 - fraction, variance), log(fraction, ratio * variance));
            let top = right.max(other);
            let sum = top + ((right - top).exp() + (other - top).exp()).ln();
            likelihood += sum;
            let posterior = (other - sum).exp();
            wrong += posterior;
            wrong_squares += posterior * visit.square;
            wrong_rows += posterior * n;
            right_squares += (1.0 - posterior) * visit.square;
            right_rows += (1.0 - posterior) * n;
        }
        let gained = likelihood - best;
        best = best.max(likelihood);
        if gained < TOLERANCE {
            break;
        }
        fraction = (wrong / visits.len().max(1) as f64).clamp(f64::MIN_POSITIVE, 0.5);
        variance = right_squares / right_rows.max(f64::MIN_POSITIVE);
        ratio =
            (wrong_squares / wrong_rows.max(f64::MIN_POSITIVE) / variance.max(f64::MIN_POSITIVE)).max(1.0);
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of three normal numbers each, at their expected quantiles (Wilson and Hilferty 1931 for χ² with 3).
    fn right(count: usize) -> Vec<LeftOut> {
        let square = |k: usize| {
            let p = (k as f64 + 0.5) / count as f64;
            // Tukey's lambda approximation of the normal quantile.
            let z = 4.91 * (p.powf(0.14) - (1.0 - p).powf(0.14));
            3.0 * (1.0 - 2.0 / 27.0 + z * (2.0_f64 / 27.0).sqrt()).powi(3)
        };
        (0..count).map(|k| LeftOut { square: square(k), log_determinant: 0.0, rows: 3 }).collect()
    }

    #[test]
    fn two_visits_of_fifty_at_six_deviations_are_contamination_and_none_are_not() {
        let mut visits = right(50);
        assert!(normal(&visits) > contaminated(&visits));
        visits[7].square = 36.0 + 2.0;
        visits[31].square = 36.0 + 2.0;
        assert!(contaminated(&visits) > normal(&visits) + 2.0);
    }

    #[test]
    fn the_unit_of_the_residuals_shifts_both_alike() {
        let visits = right(40);
        let larger: Vec<LeftOut> = visits.iter().map(|v| LeftOut { square: 1e6 * v.square, ..*v }).collect();
        let shift = 0.5 * 120.0 * 1e6_f64.ln();
        assert!((normal(&visits) - normal(&larger) - shift).abs() < 1e-9);
        assert!((contaminated(&visits) - contaminated(&larger) - shift).abs() < 1e-4);
    }
}
