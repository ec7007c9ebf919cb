//! The share of the squares that a candidate takes by chance, and how surprising a larger one is.
//!
//! The share of some of many independent numbers follows a beta law with k/2 and (n − k)/2. Numbers that are not independent are worth fewer:
//! the law is the one with the mean and the variance that the share has under random signs of the visits (Satterthwaite's way).

use statrs::function::beta::ln_beta;

/// Something of thousands of candidates is always more surprising than this: smaller surprises are not told apart.
pub(crate) const LEAST: f64 = 5.0;

/// A beta law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Share {
    a: f64,
    b: f64,
    /// ln(b B(a, b)).
    start: f64,
}

impl Share {
    /// With this mean and variance; no narrower than of so many independent numbers.
    pub fn new(mean: f64, variance: f64, numbers: usize) -> Self {
        /// Parameters below these are a law of nothing but ends.
        const LEAST: (f64, f64) = (0.05, 0.5);
        let mean = mean.clamp(1e-9, 0.999);
        let wide = mean * (1.0 - mean);
        let sum = (wide / variance.max(1e-300) - 1.0).min(0.5 * numbers as f64);
        let (a, b) = ((mean * sum).max(LEAST.0), ((1.0 - mean) * sum).max(LEAST.1));
        Share { a, b, start: b.ln() + ln_beta(a, b) }
    }

    /// Of what is not there.
    pub fn none() -> Self {
        Share::new(0.5, 1.0 / 12.0, 2)
    }

    /// −ln P(share ≥ x), or what it does not exceed where that is below [`LEAST`]: by the continued fraction of the incomplete beta function (Press
    /// et al., *Numerical Recipes*, 6.4), in logarithms, so that nothing runs out of range.
    pub fn surprise(self, x: f64) -> f64 {
        const TERMS: usize = 100;
        const TINY: f64 = 1e-300;
        let Share { a, b, start } = self;
        let bound = f64::from(self.bound().of(x as f32));
        if bound < LEAST {
            return bound.max(0.0);
        }
        let (x, y) = (x.clamp(1e-12, 1.0 - 1e-12), (1.0 - x).clamp(1e-12, 1.0));
        // Before the law's middle the fraction does not converge, and nothing is surprising.
        if y >= (b + 1.0) / (a + b + 2.0) {
            return 0.0;
        }
        let step = |term: f64, value: f64| {
            let next = 1.0 + term * value;
            if next.abs() < TINY { TINY } else { next }
        };
        let mut c = 1.0;
        let mut d = 1.0 / step(-(a + b) * y / (b + 1.0), 1.0);
        let mut fraction = d;
        for k in 1..TERMS {
            let k = k as f64;
            let even = k * (a - k) * y / ((b - 1.0 + 2.0 * k) * (b + 2.0 * k));
            let odd = -(b + k) * (a + b + k) * y / ((b + 2.0 * k) * (b + 1.0 + 2.0 * k));
            let mut factor = 1.0;
            for term in [even, odd] {
                d = 1.0 / step(term, d);
                c = step(term, 1.0 / c);
                factor *= d * c;
            }
            fraction *= factor;
            if (factor - 1.0).abs() < 1e-7 {
                break;
            }
        }
        (start - b * y.ln() - a * x.ln() - fraction.ln()).max(0.0)
    }

    /// What no surprise exceeds, at a price that thousands of candidates can pay for each flip.
    pub fn bound(self) -> Bound {
        let Share { a, b, start } = self;
        Bound { slope: b as f32, bend: (a - 1.0).max(0.0) as f32, start: start as f32 }
    }
}

/// `−b ln(1 − x) − max(a − 1, 0) ln x + ln(b B(a, b))`: in the integral of the tail, t^(a−1) is no less than at its lower end, or than one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bound {
    slope: f32,
    bend: f32,
    start: f32,
}

impl Bound {
    pub fn of(self, share: f32) -> f32 {
        let share = share.clamp(1e-30, 1.0 - 1e-6);
        self.start - self.slope * (1.0 - share).ln() - self.bend * share.ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::chi_square::surprise;
    use statrs::distribution::{Beta, ContinuousCDF};
    use statrs::statistics::Distribution;

    #[test]
    fn agrees_with_the_beta_law_and_stays_below_its_bound() {
        for (freedom, numbers) in [(1, 30.0), (2, 8.0), (2, 810.0), (6, 90.0), (24, 31.0), (40, 400.0)] {
            let (a, b) = (0.5 * f64::from(freedom), 0.5 * (numbers - f64::from(freedom)));
            let law = Beta::new(a, b).expect("positive");
            let (mean, variance) = (law.mean().expect("one"), law.variance().expect("one"));
            let share = Share::new(mean, variance, 1000);
            assert!((share.a / a - 1.0).abs() < 1e-9 && (share.b / b - 1.0).abs() < 1e-9, "{share:?}");
            for x in [0.001, 0.02, 0.1, 0.3, 0.5, 0.8, 0.95, 0.999] {
                let (expected, got) = (-law.sf(x).ln(), share.surprise(x));
                if (LEAST..300.0).contains(&expected) {
                    assert!((got - expected).abs() < 1e-5 * expected, "{share:?} {x}: {got} {expected}");
                } else if expected < LEAST {
                    assert!(got < LEAST, "{share:?} {x}: {got} {expected}");
                }
                let bound = f64::from(share.bound().of(x as f32));
                assert!(bound > got - 1e-4 * (1.0 + got), "{share:?} {x}: {bound} {got}");
            }
        }
        // Of many numbers it is the law of χ².
        let (share, numbers) = (1e-3, 1e5);
        let gain = -(numbers - 2.0) * (1.0f64 - share).ln();
        let law = Share::new(2.0 / numbers, 4.0 / numbers.powi(2), 100_000);
        assert!((law.surprise(share) - surprise(gain, 2)).abs() < 1e-2);
    }
}
