//! Conformity with a specification: how many held-out poses are inside, and the bounds for all poses.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | n | held-out poses: different pairs of joint values and load | 1 |
//! | k | of them inside: every row of every visit within the limit | 1 |
//! | L | fraction with P(K ≥ k ; n, L) = 5 %: the lower 95 % bound | 1 |
//! | U | fraction with P(K ≤ k ; n, U) = 5 %: the upper 95 % bound | 1 |
//!
//! *Pass* when L ≥ 95 %: with 95 % confidence, 95 % of poses are inside (a 95 %/95 % tolerance statement without a
//! distribution). *Fail* when U < 95 %. Otherwise it is not decided; 59 poses that are all inside are the fewest that pass.
//! Source: Clopper and Pearson 1934; Wilks 1941 for the limit.
//!
//! Measured errors contain the errors of the instrument. Where the instrument states standard deviations, each pose is compared with guard bands
//! as well (ISO 14253-1): it conforms when e + 1.645 u ≤ limit, and does not when e − 1.645 u > limit. The robot conforms when the lower 95 %
//! bound of the fraction of poses that conform is 95 % at the least, and does not when the upper bound of those that are not shown to fail is below.

use crate::{Correction, count, significant};
use serde::{Deserialize, Serialize};
use truepose_acceptance::{Conformity, GuardBand, one_sided_factor};

/// Confidence level, and the fraction of poses that has to be inside.
const LEVEL: f64 = 0.95;

/// Conformity of the held-out poses with a limit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SpecificationSummary {
    /// The limit of the 3-D position error, mm.
    pub limit_mm: f64,
    /// Held-out poses.
    pub poses: usize,
    /// Of them inside.
    pub inside: usize,
    /// With 95 % confidence, at least this fraction of all poses is inside.
    pub share_at_least: f64,
    /// With 95 % confidence, at most this fraction of all poses is inside.
    pub share_at_most: f64,
    /// With 95 % confidence, 95 % of all poses are within this, mm; none with fewer than 59 poses.
    pub tolerance_mm: Option<f64>,
    /// The verdict.
    pub verdict: Verdict,
    /// The same with guard bands; none where the instrument states no standard deviations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guard_band: Option<GuardBandSummary>,
    /// What will be done with the result: all figures above are of it.
    #[serde(default)]
    pub correction: Correction,
}

/// Held-out poses against a limit with guard bands.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GuardBandSummary {
    /// Guard band divided by the standard uncertainty: 1.645, 95 % one-sided.
    pub factor: f64,
    /// RMS of the standard uncertainties of the measured errors, from the instrument, mm.
    pub u_mm: f64,
    /// Poses that conform.
    pub conform: usize,
    /// Poses that do not.
    pub not_conform: usize,
    /// Poses of which neither is shown.
    pub undecided: usize,
    /// With 95 % confidence, at least this fraction of all poses conforms.
    pub share_at_least: f64,
    /// With 95 % confidence, at most this fraction of all poses is not shown to fail.
    pub share_at_most: f64,
    /// The verdict.
    pub verdict: GuardedVerdict,
}

/// Verdict of the decision rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GuardedVerdict {
    /// 95 % of poses conform, with 95 % confidence.
    Conform,
    /// They do not.
    NotConform,
    /// Neither is shown.
    Undecided,
}

impl GuardedVerdict {
    /// Its words.
    pub fn name(self) -> &'static str {
        match self {
            GuardedVerdict::Conform => "conform",
            GuardedVerdict::NotConform => "not conform",
            GuardedVerdict::Undecided => "undecided",
        }
    }
}

/// Whether 95 % of poses are inside, with 95 % confidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// They are.
    Pass,
    /// They are not.
    Fail,
    /// These poses are too few, or too near to the limit.
    #[serde(rename = "cannot_tell")]
    Undecided,
}

impl SpecificationSummary {
    /// Of a limit (m) and the largest error of each held-out pose (m).
    pub fn new(limit: f64, worst: &[f64]) -> Self {
        let mut sorted: Vec<f64> = worst.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        let inside = sorted.iter().filter(|v| **v <= limit).count();
        let (lower, upper) = bounds(n, inside);
        // The smallest order statistic that is above 95 % of poses with 95 % confidence.
        let order = (1..=n).find(|m| at_most(n, m - 1, LEVEL) >= LEVEL);
        SpecificationSummary {
            limit_mm: limit * 1e3,
            poses: n,
            inside,
            share_at_least: lower,
            share_at_most: upper,
            tolerance_mm: order.map(|m| sorted[m - 1] * 1e3),
            verdict: match (lower >= LEVEL, upper < LEVEL) {
                (true, _) => Verdict::Pass,
                (_, true) => Verdict::Fail,
                _ => Verdict::Undecided,
            },
            guard_band: None,
            correction: Correction::None,
        }
    }

    /// The same with guard bands, of the largest error of each pose and its standard uncertainty (m); without uncertainties as it is.
    #[must_use]
    pub fn with_guard_band(self, worst: &[(f64, f64)]) -> Self {
        let known: Vec<(f64, f64)> = worst
            .iter()
            .copied()
            .filter(|(error, u)| error.is_finite() && u.is_finite() && *u > 0.0)
            .collect();
        let n = known.len();
        if n == 0 || n != worst.iter().filter(|(error, _)| error.is_finite()).count() {
            return self;
        }
        let limit = 1e-3 * self.limit_mm;
        let verdict = |&(error, u): &(f64, f64)| GuardBand::of_known(error, u, limit).verdict;
        let of = |wanted: Conformity| known.iter().filter(|pose| verdict(pose) == wanted).count();
        let (conform, not_conform) = (of(Conformity::Conform), of(Conformity::NotConform));
        let (at_least, at_most) = (bounds(n, conform).0, bounds(n, n - not_conform).1);
        let guard_band = GuardBandSummary {
            factor: one_sided_factor(),
            u_mm: 1e3 * (known.iter().map(|(_, u)| u * u).sum::<f64>() / n as f64).sqrt(),
            conform,
            not_conform,
            undecided: n - conform - not_conform,
            share_at_least: at_least,
            share_at_most: at_most,
            verdict: match (at_least >= LEVEL, at_most < LEVEL) {
                (true, _) => GuardedVerdict::Conform,
                (_, true) => GuardedVerdict::NotConform,
                _ => GuardedVerdict::Undecided,
            },
        };
        SpecificationSummary { guard_band: Some(guard_band), ..self }
    }

    /// One sentence: the verdict with its figures.
    pub fn sentence(&self) -> String {
        let percent = |fraction: f64| format!("{} %", significant(100.0 * fraction, 3));
        let answer = match self.verdict {
            Verdict::Pass => "pass".to_owned(),
            Verdict::Fail => "fail".to_owned(),
            Verdict::Undecided if self.poses < 59 => {
                "not decided (at least 59 held-out poses are needed)".to_owned()
            }
            Verdict::Undecided => "not decided".to_owned(),
        };
        let limit = match self.tolerance_mm {
            Some(mm) => {
                format!(" 95 % of all poses are within {} mm, with the same confidence.", significant(mm, 3))
            }
            None => String::new(),
        };
        let guarded = self.guard_band.map_or_else(String::new, |guard| {
            format!(
                " With guard bands of {:.3} u (ISO 14253-1, 95 % one-sided; u = {} mm RMS, as the instrument states): {}; {} conform, {} do not, \
                 {} undecided.",
                guard.factor,
                significant(guard.u_mm, 2),
                guard.verdict.name(),
                count(guard.conform, "pose"),
                guard.not_conform,
                guard.undecided
            )
        });
        format!(
            "Specification {} mm ({}): {answer}. {} of {} are inside; with 95 % confidence (one-sided bounds), between {} and {} of all \
             poses are inside (required: 95 %).{limit}{guarded}",
            significant(self.limit_mm, 3),
            self.correction.name(),
            self.inside,
            count(self.poses, "held-out pose"),
            percent(self.share_at_least),
            percent(self.share_at_most),
        )
    }
}

impl Verdict {
    /// Name of the verdict.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Pass => "pass",
            Verdict::Fail => "fail",
            Verdict::Undecided => "not decided",
        }
    }
}

/// Lower and upper 95 % bound of a fraction, each one-sided.
fn bounds(n: usize, inside: usize) -> (f64, f64) {
    let risk = 1.0 - LEVEL;
    let lower = if inside == 0 { 0.0 } else { solve(|p| at_least(n, inside, p) - risk) };
    let upper = if inside == n { 1.0 } else { solve(|p| risk - at_most(n, inside, p)) };
    (lower, upper)
}

/// P(K ≥ k).
fn at_least(n: usize, k: usize, p: f64) -> f64 {
    if k == 0 { 1.0 } else { 1.0 - at_most(n, k - 1, p) }
}

/// P(K ≤ k) of a binomial distribution, summed in logarithms.
fn at_most(n: usize, k: usize, p: f64) -> f64 {
    if k >= n || p <= 0.0 {
        return 1.0;
    }
    if p >= 1.0 {
        return 0.0;
    }
    let (log, other) = (p.ln(), (-p).ln_1p());
    let mut choose = 0.0;
    let mut sum = 0.0;
    for i in 0..=k {
        sum += (choose + i as f64 * log + (n - i) as f64 * other).exp();
        choose += ((n - i) as f64 / (i + 1) as f64).ln();
    }
    sum.min(1.0)
}

/// Root of a function that rises over 0…1.
fn solve(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fifty_nine_poses_inside_are_the_fewest_that_pass() {
        let of = |n: usize| SpecificationSummary::new(1.0, &vec![0.5; n]);
        assert_eq!(of(58).verdict, Verdict::Undecided);
        assert_eq!(of(59).verdict, Verdict::Pass);
        assert!(of(58).tolerance_mm.is_none());
        assert!((of(59).tolerance_mm.unwrap() - 500.0).abs() < 1e-9);
        // 0.05^(1/59)
        assert!((of(59).share_at_least - 0.05f64.powf(1.0 / 59.0)).abs() < 1e-9);
    }

    #[test]
    fn poses_near_the_limit_are_undecided_with_guard_bands() {
        let near = |error: f64, count: usize| vec![(error, 0.05); count];
        let of = |worst: &[(f64, f64)]| {
            let errors: Vec<f64> = worst.iter().map(|pose| pose.0).collect();
            SpecificationSummary::new(1.0, &errors).with_guard_band(worst).guard_band.unwrap()
        };
        // 0.95 is inside, but not by 1.645 × 0.05.
        let band = of(&near(0.95, 80));
        assert_eq!((band.conform, band.not_conform, band.undecided), (0, 0, 80));
        assert_eq!(band.verdict, GuardedVerdict::Undecided);
        assert!((band.factor - 1.6449).abs() < 1e-4 && (band.u_mm - 50.0).abs() < 1e-9);
        assert_eq!(of(&near(0.9, 80)).verdict, GuardedVerdict::Conform);
        assert_eq!(of(&near(1.1, 80)).verdict, GuardedVerdict::NotConform);
        // Errors without an uncertainty have no guard band.
        let unknown = [(0.5, f64::NAN), (0.5, 0.1)];
        assert!(SpecificationSummary::new(1.0, &[0.5, 0.5]).with_guard_band(&unknown).guard_band.is_none());
    }

    #[test]
    fn bounds_as_tables_have_them() {
        // Clopper and Pearson, one side 95 %, 8 of 10: 0.4931 and 0.9632.
        let values = [0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 2.0, 2.0];
        let s = SpecificationSummary::new(1.0, &values);
        assert!((s.share_at_least - 0.4931).abs() < 1e-4 && (s.share_at_most - 0.9632).abs() < 1e-4);
        assert_eq!(s.verdict, Verdict::Undecided);
        assert_eq!(SpecificationSummary::new(0.01, &values).verdict, Verdict::Fail);
    }

    #[test]
    fn large_samples_do_not_underflow() {
        let s = SpecificationSummary::new(1.0, &vec![0.5; 12_000]);
        assert!(s.share_at_least > 0.999 && s.share_at_most > 0.999);
        let mut values = vec![0.5; 12_000];
        values[..600].fill(2.0);
        let s = SpecificationSummary::new(1.0, &values);
        assert!(s.share_at_least < 0.95 && s.share_at_most > 0.95, "{s:?}");
    }
}
