//! A figure with its uncertainty.
//!
//! | symbol | here | |
//! | --- | --- | --- |
//! | y | `value` | m, rad or m/N |
//! | u | `u` | standard uncertainty (GUM), unit of y |
//! | ν | `freedom` | degrees of freedom of u; infinite where u is known |
//!
//! ```text
//! means and first order        [y − t_ν u, y + t_ν u]                 Student's t; exact for means of normal values
//! standard deviations, ν       [y √(ν/χ²_{0.975}), y √(ν/χ²_{0.025})]  exact for normal values;  u = y / √(2ν) to first order
//! ```
//!
//! Source: JCGM 100:2008, annex E and G.

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal, StudentsT};

/// How the uncertainty of a figure was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Student's t of a mean: exact for normally distributed values.
    Student,
    /// χ² of a standard deviation: exact for normally distributed values.
    ChiSquared,
    /// Propagated to first order, with Student's t.
    FirstOrder,
    /// Parametric bootstrap of the ratio to the expected figure.
    Bootstrap,
}

impl Method {
    /// One word.
    pub fn name(self) -> &'static str {
        match self {
            Method::Student => "Student",
            Method::ChiSquared => "chi-squared",
            Method::FirstOrder => "first order",
            Method::Bootstrap => "bootstrap",
        }
    }
}

/// A figure with its uncertainty, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figure {
    /// The figure.
    pub value: f64,
    /// Its standard uncertainty.
    pub u: f64,
    /// Degrees of freedom of `u`.
    pub freedom: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
    /// One-sided 95 % bounds: the expected figure is above the first with 95 %, and below the second with 95 %.
    pub bounds95: [f64; 2],
    /// How the uncertainty was found.
    pub method: Method,
}

impl Figure {
    /// A figure with a standard uncertainty of so many degrees of freedom.
    pub fn with_u(value: f64, u: f64, freedom: f64, method: Method) -> Self {
        let [two, one] = [student(0.975, freedom), student(0.95, freedom)].map(|t| t * u);
        let (ci95, bounds95) = ([value - two, value + two], [value - one, value + one]);
        Figure { value, u, freedom, ci95, bounds95, method }
    }

    /// `factor` times a standard deviation of so many degrees of freedom.
    pub fn of_deviation(sd: f64, factor: f64, freedom: f64) -> Self {
        let value = factor * sd;
        let at = |p: f64| {
            let quantile = ChiSquared::new(freedom).map_or(f64::NAN, |d| d.inverse_cdf(p));
            value * (freedom / quantile).sqrt()
        };
        Figure {
            value,
            u: value / (2.0 * freedom).sqrt(),
            freedom,
            ci95: [at(0.975), at(0.025)],
            bounds95: [at(0.95), at(0.05)],
            method: Method::ChiSquared,
        }
    }

    /// The expanded uncertainty U = 2 u (k = 2).
    pub fn expanded(&self) -> f64 {
        2.0 * self.u
    }

    /// In another unit.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Figure {
            value: factor * self.value,
            u: factor * self.u,
            ci95: self.ci95.map(|v| factor * v),
            bounds95: self.bounds95.map(|v| factor * v),
            ..*self
        }
    }
}

/// Quantile of Student's t; the normal distribution's for very many degrees of freedom.
pub(crate) fn student(probability: f64, freedom: f64) -> f64 {
    const MANY: f64 = 1e5;
    if freedom < MANY
        && let Ok(t) = StudentsT::new(0.0, 1.0, freedom.max(1.0))
    {
        return t.inverse_cdf(probability);
    }
    Normal::standard().inverse_cdf(probability)
}

/// Degrees of freedom of a sum of variances (Welch and Satterthwaite; GUM, G.2b): (variance, degrees of freedom) each.
pub(crate) fn welch_satterthwaite(parts: &[(f64, f64)]) -> f64 {
    let sum: f64 = parts.iter().map(|(variance, _)| variance).sum();
    let open: f64 = parts
        .iter()
        .filter(|(_, freedom)| freedom.is_finite())
        .map(|(variance, freedom)| variance * variance / freedom)
        .sum();
    if open > 0.0 { sum * sum / open } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_as_tables_have_them() {
        // t_29: 2.0452 and 1.6991; χ²_29: 16.047 and 45.722.
        let mean = Figure::with_u(1.0, 0.1, 29.0, Method::Student);
        assert!((mean.ci95[1] - 1.20452).abs() < 1e-5 && (mean.bounds95[1] - 1.16991).abs() < 1e-5);
        let known = Figure::with_u(1.0, 0.1, f64::INFINITY, Method::Student);
        assert!((known.bounds95[1] - 1.164485).abs() < 1e-6);
        let sd = Figure::of_deviation(1.0, 3.0, 29.0);
        assert!((sd.ci95[0] - 3.0 * (29.0f64 / 45.722).sqrt()).abs() < 1e-4);
        assert!((sd.ci95[1] - 3.0 * (29.0f64 / 16.047).sqrt()).abs() < 1e-4);
    }

    #[test]
    fn a_known_part_adds_no_doubt_about_the_uncertainty() {
        assert!((welch_satterthwaite(&[(1.0, 10.0)]) - 10.0).abs() < 1e-12);
        assert!((welch_satterthwaite(&[(1.0, 10.0), (1.0, f64::INFINITY)]) - 40.0).abs() < 1e-12);
        assert!(welch_satterthwaite(&[(1.0, f64::INFINITY)]).is_infinite());
    }
}
