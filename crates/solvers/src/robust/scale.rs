//! Scale of the residuals of visits that a few wrong ones do not move.
//!
//! σ̂ = median_g( u_g / √(m_{n_g} / n_g) ) · √(N / (N − rank)),  m_n = median of χ²_n
//!
//! | symbol | name | unit |
//! | --- | --- | --- |
//! | u_g | root mean square residual of a visit of n_g rows | 1 when whitened |
//! | N | rows that count | 1 |
//!
//! For visits of one row this is the MAD about zero over 0.6745. The last factor makes up for what the fit took from the
//! residuals; it matters when rows are few. Median of χ²: exact to n = 6, then Wilson and Hilferty (1931).

use crate::order::median;

/// Medians of χ² with 1 … 6 degrees of freedom.
const MEDIANS: [f64; 6] = [
    0.454_936_423_119_573,
    1.386_294_361_119_891,
    2.365_973_884_375_337,
    3.356_693_980_033_321,
    4.351_460_191_095_526,
    5.348_120_627_447_127,
];

pub(super) fn robust_scale(residuals: &[(f64, usize)], rank: usize) -> f64 {
    let standard = residuals
        .iter()
        .filter(|(_, n)| *n > 0)
        .map(|(u, n)| u / (median_of_chi_square(*n) / *n as f64).sqrt());
    let rows: usize = residuals.iter().map(|(_, n)| n).sum();
    let free = rows.saturating_sub(rank).max(1);
    median(standard).unwrap_or(0.0) * (rows.max(1) as f64 / free as f64).sqrt()
}

pub(super) fn median_of_chi_square(n: usize) -> f64 {
    let f = n as f64;
    MEDIANS.get(n.saturating_sub(1)).copied().unwrap_or_else(|| f * (1.0 - 2.0 / (9.0 * f)).powi(3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_row_visits_give_the_mad() {
        let r: Vec<(f64, usize)> = [1.0, 2.0, 3.0, 100.0, 2.5].iter().map(|u| (*u, 1)).collect();
        assert!((robust_scale(&r, 0) - 2.5 / 0.674_489_750_196_081_7).abs() < 1e-9);
        assert!(robust_scale(&[], 0).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn medians_continue_smoothly() {
        let steps: Vec<f64> =
            (1..12).map(|n| median_of_chi_square(n + 1) - median_of_chi_square(n)).collect();
        assert!(steps.iter().all(|s| (0.9..1.01).contains(s)), "{steps:?}");
    }
}
