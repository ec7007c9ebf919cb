//! Conformity with a limit: decision rule with guard bands.
//!
//! ```text
//! conform        y + g ≤ L                g: guard band, so that the statement holds with 95 % (one-sided)
//! not conform    y − g > L
//! undecided      otherwise
//! ```
//!
//! | symbol | here | |
//! | --- | --- | --- |
//! | y, L | value, limit | one unit |
//! | g | k u, k = 1.645 where u is known; k = t_{0.95, ν} where it has ν degrees of freedom | |
//!
//! Figures whose distribution is not symmetric (repeatability) have bounds of their own in place of y ± g.
//! Source: ISO 14253-1 (decision rules, 95 % one-sided), JCGM 106.

use crate::figure::{Figure, student};

/// Verdict of a decision rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Conformity {
    /// Conformity is shown.
    Conform,
    /// Non-conformity is shown.
    NotConform,
    /// The limit lies within the guard bands: neither is shown.
    Undecided,
}

impl Conformity {
    /// Its words.
    pub fn name(self) -> &'static str {
        match self {
            Conformity::Conform => "conform",
            Conformity::NotConform => "not conform",
            Conformity::Undecided => "undecided",
        }
    }

    /// The worst of several characteristics: conform where all are, not conform where one is not.
    pub fn of_all(all: impl IntoIterator<Item = Conformity>) -> Conformity {
        all.into_iter().fold(Conformity::Conform, |worst, next| match (worst, next) {
            (Conformity::NotConform, _) | (_, Conformity::NotConform) => Conformity::NotConform,
            (Conformity::Undecided, _) | (_, Conformity::Undecided) => Conformity::Undecided,
            _ => Conformity::Conform,
        })
    }
}

/// A figure against an upper limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GuardBand {
    /// The limit.
    pub limit: f64,
    /// The magnitude that is compared.
    pub value: f64,
    /// Guard bands below and above it.
    pub guard: [f64; 2],
    /// The factor of the standard uncertainty, k = g/u of the upper guard band.
    pub factor: f64,
    /// The verdict.
    pub verdict: Conformity,
}

impl GuardBand {
    /// The magnitude of a figure against an upper limit.
    pub fn new(figure: &Figure, limit: f64) -> Self {
        let [below, above] = figure.bounds95.map(|bound| (bound - figure.value).abs());
        // Of a negative figure the lower bound is the one that its magnitude may exceed.
        let guard = if figure.value < 0.0 { [above, below] } else { [below, above] };
        let value = figure.value.abs();
        let verdict = verdict(value, guard, limit);
        let factor = if figure.u > 0.0 { guard[1] / figure.u } else { student(0.95, figure.freedom) };
        GuardBand { limit, value, guard, factor, verdict }
    }

    /// A value (≥ 0) with a known standard uncertainty against an upper limit.
    pub fn of_known(value: f64, u: f64, limit: f64) -> Self {
        let factor = one_sided_factor();
        let guard = [factor * u; 2];
        GuardBand { limit, value, guard, factor, verdict: verdict(value, guard, limit) }
    }
}

fn verdict(value: f64, guard: [f64; 2], limit: f64) -> Conformity {
    if value + guard[1] <= limit {
        Conformity::Conform
    } else if value - guard[0] > limit {
        Conformity::NotConform
    } else {
        Conformity::Undecided
    }
}

/// The factor of a known standard uncertainty for 95 %, one-sided: 1.645.
pub fn one_sided_factor() -> f64 {
    student(0.95, f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Method;

    #[test]
    fn limits_within_the_guard_band_are_undecided() {
        let of = |value: f64| GuardBand::of_known(value, 0.1, 1.0).verdict;
        assert_eq!(of(0.835), Conformity::Conform);
        assert_eq!(of(0.836), Conformity::Undecided);
        assert_eq!(of(1.164), Conformity::Undecided);
        assert_eq!(of(1.165), Conformity::NotConform);
    }

    #[test]
    fn signs_and_degrees_of_freedom_count() {
        let figure = Figure::with_u(-0.9, 0.1, 5.0, Method::Student);
        let band = GuardBand::new(&figure, 1.0);
        assert!((band.value - 0.9).abs() < 1e-15 && (band.factor - 2.015).abs() < 1e-3);
        assert_eq!(band.verdict, Conformity::Undecided);
    }

    #[test]
    fn one_that_does_not_conform_decides() {
        use Conformity::{Conform, NotConform, Undecided};
        assert_eq!(Conformity::of_all([Conform, Undecided]), Undecided);
        assert_eq!(Conformity::of_all([Conform, NotConform, Undecided]), NotConform);
        assert_eq!(Conformity::of_all([]), Conform);
    }
}
