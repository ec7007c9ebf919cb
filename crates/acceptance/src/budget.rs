//! An uncertainty budget: contributions to the uncertainty of a position, axis by axis.
//!
//! ```text
//! u_c² = Σ_i u_i²  for each axis,     u_total² = u_x² + u_y² + u_z²,     U = k u_c,  k = 2
//! ν_eff = u_total⁴ / Σ u_i⁴/ν_i
//! ```
//!
//! The contributions are of independent causes, with sensitivity one: each is an uncertainty of the position itself, propagated there before.
//! Source: JCGM 100:2008, 5.1 and G.4.

use crate::figure::welch_satterthwaite;

/// How a contribution was evaluated (GUM 4.2 and 4.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Evaluation {
    /// From the scatter of observations.
    A,
    /// From other knowledge.
    B,
}

/// One contribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Contribution {
    /// Its source, in words.
    pub source: String,
    /// How it was evaluated.
    pub evaluation: Evaluation,
    /// Standard uncertainty of x, y, z, m.
    pub u: [f64; 3],
    /// Degrees of freedom; infinite where it is known.
    pub freedom: f64,
}

impl Contribution {
    /// Of variances of x, y, z, m²; negative ones, which estimates of remainders can have, are zero.
    pub fn of_variances(source: &str, evaluation: Evaluation, variances: [f64; 3], freedom: f64) -> Self {
        let u = variances.map(|v| v.max(0.0).sqrt());
        Contribution { source: source.into(), evaluation, u, freedom }
    }

    /// Standard uncertainty of the position, all axes, m.
    pub fn total(&self) -> f64 {
        self.u.iter().map(|u| u * u).sum::<f64>().sqrt()
    }
}

/// Contributions to the uncertainty of one position.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Budget {
    /// In the order in which they are shown.
    pub contributions: Vec<Contribution>,
}

impl Budget {
    /// The coverage factor of expanded uncertainties.
    pub const COVERAGE_FACTOR: f64 = 2.0;

    /// Combined standard uncertainty of x, y, z, m.
    pub fn combined(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| self.contributions.iter().map(|c| c.u[k] * c.u[k]).sum::<f64>().sqrt())
    }

    /// Combined standard uncertainty of the position, all axes, m.
    pub fn total(&self) -> f64 {
        self.combined().iter().map(|u| u * u).sum::<f64>().sqrt()
    }

    /// Effective degrees of freedom of [`Budget::total`].
    pub fn freedom(&self) -> f64 {
        let parts: Vec<(f64, f64)> =
            self.contributions.iter().map(|c| (c.total().powi(2), c.freedom)).collect();
        welch_satterthwaite(&parts)
    }

    /// The part of a contribution in the variance of the position, 0 to 1.
    pub fn fraction(&self, contribution: &Contribution) -> f64 {
        let whole = self.total().powi(2);
        if whole > 0.0 { contribution.total().powi(2) / whole } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variances_add_up() {
        let of = |u: [f64; 3], freedom| Contribution {
            source: String::new(),
            evaluation: Evaluation::A,
            u,
            freedom,
        };
        let budget =
            Budget { contributions: vec![of([3.0, 0.0, 0.0], 10.0), of([4.0, 0.0, 12.0], f64::INFINITY)] };
        assert_eq!(budget.combined().map(|u| u.round() as i64), [5, 0, 12]);
        assert!((budget.total() - 13.0).abs() < 1e-12);
        assert!((budget.fraction(&budget.contributions[0]) - 9.0 / 169.0).abs() < 1e-12);
        assert!((budget.freedom() - 169.0f64.powi(2) / (81.0 / 10.0)).abs() < 1e-9);
        let none = Contribution::of_variances("", Evaluation::B, [-1.0, 4.0, 0.0], 1.0);
        assert!((none.total() - 2.0).abs() < 1e-15);
    }
}
