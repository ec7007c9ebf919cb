//! The explained fraction of a candidate when nothing is missing, and how surprising a larger one is.
//!
//! With an orthonormal basis of the orthogonal complement of all nuisance columns the whitened residual z ∈ R^ν has, under normal errors, a
//! uniform direction, and the fraction of ‖z‖² that k given directions explain is distributed as `Beta(k/2, (ν − k)/2)`, whatever ν.
//! Source: Langsrud (2005), *Rotation tests*; the tail by the continued fraction of the incomplete beta function (Press et al., *Numerical
//! Recipes*, 6.4), in logarithms, so that nothing runs out of range.

use statrs::function::beta::{beta_reg, ln_beta};

/// −ln P(fraction ≥ x) of k directions among ν; 0 where nothing is explained.
pub(crate) fn surprisal(x: f64, k: usize, freedom: usize) -> f64 {
    const TERMS: usize = 200;
    const TINY: f64 = 1e-300;
    if k >= freedom || x.is_nan() || x <= 0.0 {
        return 0.0;
    }
    let (a, b) = (0.5 * k as f64, 0.5 * (freedom - k) as f64);
    let (x, y) = (x.clamp(1e-15, 1.0 - 1e-15), (1.0 - x).clamp(1e-15, 1.0));
    // Below the middle the fraction does not converge.
    if y >= (b + 1.0) / (a + b + 2.0) {
        return -beta_reg(b, a, y).max(f64::MIN_POSITIVE).ln();
    }
    let step = |term: f64, value: f64| {
        let next = 1.0 + term * value;
        if next.abs() < TINY { TINY } else { next }
    };
    let mut c = 1.0;
    let mut d = 1.0 / step(-(a + b) * y / (b + 1.0), 1.0);
    let mut fraction = d;
    for m in 1..TERMS {
        let m = m as f64;
        let even = m * (a - m) * y / ((b - 1.0 + 2.0 * m) * (b + 2.0 * m));
        let odd = -(b + m) * (a + b + m) * y / ((b + 2.0 * m) * (b + 1.0 + 2.0 * m));
        let mut factor = 1.0;
        for term in [even, odd] {
            d = 1.0 / step(term, d);
            c = step(term, 1.0 / c);
            factor *= d * c;
        }
        fraction *= factor;
        if (factor - 1.0).abs() < 1e-10 {
            break;
        }
    }
    (b.ln() + ln_beta(a, b) - b * y.ln() - a * x.ln() - fraction.ln()).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{Beta, ContinuousCDF};

    #[test]
    fn agrees_with_the_distribution_where_that_is_in_range() {
        for (k, freedom) in [(1, 30), (2, 8), (2, 810), (6, 90), (24, 31), (40, 400)] {
            let beta = Beta::new(0.5 * f64::from(k), 0.5 * f64::from(freedom - k)).expect("positive");
            for x in [0.001, 0.02, 0.1, 0.3, 0.5, 0.8, 0.95, 0.999] {
                let expected = -beta.sf(x).ln();
                let got = surprisal(x, k as usize, freedom as usize);
                if expected < 300.0 && expected.is_finite() {
                    assert!(
                        (got - expected).abs() < 1e-6 * (1.0 + expected),
                        "{k} {freedom} {x}: {got} {expected}"
                    );
                }
            }
        }
    }
}
