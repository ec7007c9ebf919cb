//! Gross errors among squared distances: a law of their own, beside a bulk whose tail may be heavy.
//!
//! ```text
//! x_i ~ (1 − π) F(3, ν) + π g,     g(x) = 1 / (x ln(x_max / x_0))  on [x_0, x_max]        x = t²/3 in units of the bulk's variance
//! D = 2 [max over ν, π of log L − max over ν of log L at π = 0]
//! ```
//!
//! g says nothing about a gross error but that it is large: log-uniform from the least that is one. A handful of them drags the
//! upper quantiles along and makes the bulk look heavy-tailed; the gap between them and the bulk is what tells the two apart, and
//! D sees it: a heavy tail has no gap. Source: Aitkin and Wilson, *Mixture models, outliers, and the EM algorithm* (1980).

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};
use statrs::function::gamma::ln_gamma;

/// The law of t²/3 of a good row: χ²/3, or F(3, ν) for heavier tails.
pub(crate) enum Law {
    Normal(ChiSquared),
    Heavy(FisherSnedecor, f64),
}

impl Law {
    /// ν degrees of freedom; 100 and more is normal.
    pub fn new(freedom: f64) -> Self {
        match FisherSnedecor::new(3.0, freedom) {
            Ok(heavy) if freedom < 100.0 => Law::Heavy(heavy, freedom),
            _ => match ChiSquared::new(3.0) {
                Ok(normal) => Law::Normal(normal),
                Err(_) => unreachable!("three is a number of degrees of freedom"),
            },
        }
    }

    pub fn above(&self, x: f64) -> f64 {
        match self {
            Law::Normal(law) => law.sf(3.0 * x),
            Law::Heavy(law, _) => law.sf(x),
        }
    }

    pub fn quantile(&self, share: f64) -> f64 {
        match self {
            Law::Normal(law) => law.inverse_cdf(share) / 3.0,
            Law::Heavy(law, _) => law.inverse_cdf(share),
        }
    }

    /// Logarithm of the density at every x.
    fn ln_densities(&self, all: impl Iterator<Item = f64>) -> Vec<f64> {
        let common = 1.5 * 3f64.ln() - ln_gamma(1.5);
        match self {
            Law::Normal(_) => {
                let constant = common - 1.5 * 2f64.ln();
                all.map(|x| constant + 0.5 * x.ln() - 1.5 * x).collect()
            }
            Law::Heavy(_, freedom) => {
                let half = 0.5 * (3.0 + freedom);
                let constant = common + ln_gamma(half) - ln_gamma(0.5 * freedom) - 1.5 * freedom.ln();
                all.map(|x| constant + 0.5 * x.ln() - half * (3.0 * x / freedom).ln_1p()).collect()
            }
        }
    }
}

/// What a sample says of gross errors.
pub(crate) struct Gross {
    /// D.
    pub gain: f64,
    /// Of each square, in the order given, how much more likely it is gross than good.
    pub odds: Vec<f64>,
}

/// Splits squared distances t² into a bulk and gross errors. `scale` is the variance of one axis at which the bulk's median is the
/// sample's, were this its law; `least` the t² from which on an error may be gross, in such variances.
pub(crate) fn split(squares: &[f64], scale: impl Fn(&Law) -> f64, least: f64) -> Gross {
    /// Steps of 1/ν from zero to one.
    const STEPS: usize = 40;
    /// Of the share of gross errors.
    const ROUNDS: usize = 40;
    /// More are no outliers.
    const MOST: f64 = 0.15;
    let start = least / 3.0;
    let (mut alone, mut best) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    let mut found = Gross { gain: 0.0, odds: vec![0.0; squares.len()] };
    for step in 0..=STEPS {
        let law = Law::new(STEPS as f64 / (step as f64).max(1e-9));
        let unit = 3.0 * scale(&law);
        // One density for all laws: of t² in units of the normal law's variance would differ by the logarithm of the scale.
        let jacobian = unit.ln();
        let good: Vec<f64> = law.ln_densities(squares.iter().map(|t| (t / unit).max(1e-12)));
        let good: Vec<f64> = good.iter().map(|ln| ln - jacobian).collect();
        alone = alone.max(good.iter().sum());
        let largest = squares.iter().copied().fold(4.0 * start * unit, f64::max);
        let width = (largest / (start * unit)).ln();
        let ratio: Vec<f64> = squares
            .iter()
            .zip(&good)
            .map(|(&t, ln)| if t >= start * unit { (-(t * width).ln() - ln).min(500.0).exp() } else { 0.0 })
            .collect();
        let count = squares.len() as f64;
        let mut share = 0.5 / count.max(1.0);
        for _ in 0..ROUNDS {
            let odds = |r: &f64| share * r / (1.0 - share + share * r);
            share = (ratio.iter().map(odds).sum::<f64>() / count).min(MOST);
        }
        let value: f64 = good.iter().zip(&ratio).map(|(ln, r)| ln + (1.0 - share + share * r).ln()).sum();
        if value > best {
            best = value;
            found.odds = ratio.iter().map(|r| share * r / (1.0 - share)).collect();
        }
    }
    found.gain = 2.0 * (best - alone).max(0.0);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares whose t²/3 are the quantiles of a law, times three.
    fn bulk(law: &Law, count: usize) -> Vec<f64> {
        (0..count).map(|k| 3.0 * law.quantile((k as f64 + 0.5) / count as f64)).collect()
    }

    fn split_of(squares: &[f64]) -> Gross {
        let mut sorted = squares.to_vec();
        sorted.sort_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2];
        split(squares, |law| median / (3.0 * law.quantile(0.5)), 25.0)
    }

    #[test]
    fn densities_are_those_of_the_laws() {
        let points = [0.01, 0.3, 1.0, 4.0, 30.0];
        let step = 1e-6;
        for law in [Law::new(1e9), Law::new(30.0), Law::new(3.0)] {
            for (x, ln) in points.iter().zip(law.ln_densities(points.into_iter())) {
                let slope = (law.above(x - step * x) - law.above(x + step * x)) / (2.0 * step * x);
                assert!((ln.exp() - slope).abs() < 1e-5 * slope.max(1e-9) + 1e-9, "{x}: {ln} {slope}");
            }
        }
    }

    #[test]
    fn a_heavy_tail_is_no_gross_error() {
        for freedom in [1e9, 10.0, 4.0, 2.5] {
            let gross = split_of(&bulk(&Law::new(freedom), 200));
            assert!(gross.gain < 3.0, "{freedom}: {}", gross.gain);
        }
    }

    #[test]
    fn several_gross_errors_do_not_hide_each_other() {
        // Five per cent, ten deviations long.
        let mut squares = bulk(&Law::new(1e9), 95);
        squares.extend([80.0, 90.0, 100.0, 110.0, 120.0]);
        let gross = split_of(&squares);
        assert!(gross.gain > 20.0, "{}", gross.gain);
        let marked: Vec<usize> = (0..squares.len()).filter(|&k| gross.odds[k] > 99.0).collect();
        assert_eq!(marked, [95, 96, 97, 98, 99]);
    }
}
