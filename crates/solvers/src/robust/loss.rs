//! What a large residual costs, as the factor that it puts on a weight.
//!
//! | loss | w(t) |
//! | --- | --- |
//! | Huber | 1 for t ≤ k, else k / t |
//! | Tukey | (1 − (t/c)²)² for t ≤ c, else 0 |
//! | least squares | 1 |
//!
//! k = 1.345 and c = 4.685 have 95 % efficiency on Gaussian residuals. Source: Holland and Welsch (1977).

use crate::SolveError;

/// A loss of the standardised residual t ≥ 0 of a visit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Loss {
    /// Quadratic up to `k`, linear beyond.
    Huber {
        /// Where the pull of a visit stops growing.
        k: f64,
    },
    /// Constant beyond `c`: such a visit does not count.
    Tukey {
        /// Where a visit stops counting.
        c: f64,
    },
}

impl Loss {
    /// Huber's with k = 1.345.
    pub fn huber() -> Self {
        Loss::Huber { k: 1.345 }
    }

    /// Tukey's with c = 4.685.
    pub fn tukey() -> Self {
        Loss::Tukey { c: 4.685 }
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Loss::Huber { .. } => "huber",
            Loss::Tukey { .. } => "tukey",
        }
    }

    /// Factor on the weights of a visit with standardised residual `t`.
    pub fn weight(&self, t: f64) -> f64 {
        match *self {
            Loss::Huber { k } => {
                if t <= k {
                    1.0
                } else {
                    k / t
                }
            }
            Loss::Tukey { c } => {
                if t < c {
                    (1.0 - (t / c).powi(2)).powi(2)
                } else {
                    0.0
                }
            }
        }
    }

    /// How fast that factor falls: w'(t) / t, never above zero.
    pub fn slope(&self, t: f64) -> f64 {
        match *self {
            Loss::Huber { k } if t > k => -k / t.powi(3),
            Loss::Tukey { c } if t < c => -4.0 * (1.0 - (t / c).powi(2)) / (c * c),
            _ => 0.0,
        }
    }

    /// Refuses constants that are not positive.
    pub fn validate(&self) -> Result<(), SolveError> {
        let (option, value) = match *self {
            Loss::Huber { k } => ("k", k),
            Loss::Tukey { c } => ("c", c),
        };
        if value > 0.0 && value.is_finite() {
            Ok(())
        } else {
            Err(SolveError::BadOption { option, value, expected: "a finite number > 0" })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_fall_from_one() {
        for loss in [Loss::huber(), Loss::tukey()] {
            assert!((loss.weight(0.0) - 1.0).abs() < 1e-15);
            assert!((0..100).all(|t| loss.weight(0.1 * t as f64) >= loss.weight(0.1 * (t + 1) as f64)));
        }
        assert!(Loss::tukey().weight(5.0) < 1e-15 && Loss::huber().weight(2.69) > 0.49);
        assert!(Loss::Huber { k: -1.0 }.validate().is_err());
    }

    #[test]
    fn the_slope_is_that_of_the_weight() {
        for loss in [Loss::huber(), Loss::tukey()] {
            for t in [0.4, 1.2, 1.5, 3.0, 4.6, 5.0] {
                let difference = (loss.weight(t + 1e-6) - loss.weight(t - 1e-6)) / 2e-6;
                assert!((loss.slope(t) * t - difference).abs() < 1e-8, "{loss:?} at {t}");
            }
        }
    }
}
