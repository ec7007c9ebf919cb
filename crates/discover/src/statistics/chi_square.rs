//! Gains with different numbers of unknowns on one scale: how surprising each would be for a single question.
//!
//! ```text
//! surprise = −ln P(χ²_k ≥ gain)
//! ```
//!
//! Normal approximations (Wilson and Hilferty) are wrong by many deviations so far out, and in favour of rich candidates: a gain of 590
//! would count for more with 36 unknowns than with one. The tail of the incomplete gamma function by its continued fraction
//! (Lentz's method: Press et al., Numerical Recipes, 6.2), in logarithms, so that nothing runs out of range.

use statrs::function::gamma::{gamma_ur, ln_gamma};

/// −ln P(χ² ≥ gain) with so many degrees of freedom; zero or more.
pub(crate) fn surprisal(gain: f64, freedom: usize) -> f64 {
    let (a, x) = (0.5 * freedom.max(1) as f64, 0.5 * gain.max(0.0));
    if x <= a + 1.0 {
        return if x > 0.0 { -gamma_ur(a, x).ln() } else { 0.0 };
    }
    const TINY: f64 = 1e-300;
    const TERMS: usize = 300;
    let mut b = x + 1.0 - a;
    let mut c = 1.0 / TINY;
    let mut d = 1.0 / b;
    let mut fraction = d;
    for k in 1..TERMS {
        let an = -(k as f64) * (k as f64 - a);
        b += 2.0;
        d = 1.0 / (an * d + b).abs().max(TINY).copysign(an * d + b);
        c = b + an / c;
        let factor = c * d;
        fraction *= factor;
        if (factor - 1.0).abs() < 1e-12 {
            break;
        }
    }
    x - a * x.ln() + ln_gamma(a) - fraction.ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    #[test]
    fn agrees_with_the_distribution_where_that_is_in_range() {
        for freedom in [1, 2, 3, 6, 21, 60] {
            let distribution = ChiSquared::new(freedom as f64).expect("positive");
            for gain in [0.01, 0.5, 1.0, 3.0, 7.0, 20.0, 61.0, 64.0, 100.0, 300.0] {
                let expected = -distribution.sf(gain).ln();
                if expected < 300.0 {
                    let got = surprisal(gain, freedom);
                    assert!(
                        (got - expected).abs() < 1e-9 * (1.0 + expected),
                        "{freedom} {gain}: {got} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn far_out_a_simple_cause_is_the_more_surprising_one() {
        // Asymptotics of one degree of freedom: P ≈ √(2/(π x)) e^{−x/2}.
        let x: f64 = 5900.0;
        let expected = 0.5 * x + 0.5 * (std::f64::consts::FRAC_PI_2 * x).ln();
        assert!((surprisal(x, 1) - expected).abs() < 1e-3);
        assert!(surprisal(590.0, 1) > surprisal(590.0, 36));
    }
}
