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

use crate::{count, significant};
use serde::{Deserialize, Serialize};

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
        let risk = 1.0 - LEVEL;
        let lower = if inside == 0 { 0.0 } else { solve(|p| at_least(n, inside, p) - risk) };
        let upper = if inside == n { 1.0 } else { solve(|p| risk - at_most(n, inside, p)) };
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
        }
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
        format!(
            "Specification {} mm: {answer}. {} of {} are inside; with 95 % confidence (one-sided bounds), between {} and {} of all \
             poses are inside (required: 95 %).{limit}",
            significant(self.limit_mm, 3),
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
