//! How many directions the data determine.
//!
//! rank = #{ k : d_k > τ },  gap = d_rank / d_{rank+1}
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | d | singular values (or pivots) of the scaled matrix, largest first | min(m, p) | 1 |
//! | τ | tolerance | 1 | that of d |
//!
//! Source: Golub and Van Loan, *Matrix Computations*, 4th ed., §5.4–5.5; the default tolerance is LAPACK's and numpy's.
//! A rank is worth what its gap is worth: report both.

use crate::SolveError;

/// Below which value a direction counts as undetermined.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum RankRule {
    /// max(m, p) · ε · d_1.
    #[default]
    Default,
    /// This fraction of the largest value.
    Relative(f64),
    /// This value.
    Absolute(f64),
    /// At the widest gap among the values between `floor`·d_1 and d_1, if it is at least `least`; else the default rule.
    WidestGap {
        /// Values below this fraction of d_1 are round-off in any case.
        floor: f64,
        /// Values above this fraction of d_1 are kept in any case.
        ceiling: f64,
        /// A narrower gap decides nothing.
        least: f64,
    },
}

impl RankRule {
    /// The widest gap of at least `least` between 1e-13 and 1e-3 of the largest value.
    pub fn widest_gap(least: f64) -> Self {
        RankRule::WidestGap { floor: 1e-13, ceiling: 1e-3, least }
    }

    /// Refuses tolerances that are not numbers in range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let bad = |option, value, expected| Err(SolveError::BadOption { option, value, expected });
        match *self {
            RankRule::Default => Ok(()),
            RankRule::Relative(r) if !(0.0..1.0).contains(&r) => bad("rcond", r, "0 ≤ rcond < 1"),
            RankRule::Absolute(a) if !(a >= 0.0 && a.is_finite()) => {
                bad("tolerance", a, "a finite number ≥ 0")
            }
            RankRule::WidestGap { floor, ceiling, .. }
                if !(0.0 <= floor && floor < ceiling && ceiling <= 1.0) =>
            {
                bad("floor", floor, "0 ≤ floor < ceiling ≤ 1")
            }
            RankRule::WidestGap { least, .. } if least < 1.0 || least.is_nan() => {
                bad("least", least, "a ratio ≥ 1")
            }
            _ => Ok(()),
        }
    }
}

/// The rank, with the values next to the cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RankDecision {
    /// Number of values kept.
    pub rank: usize,
    /// The cut.
    pub tolerance: f64,
    /// Smallest value kept; 0 if none was.
    pub last_kept: f64,
    /// Largest value dropped; 0 if none was, or if it is zero.
    pub first_dropped: f64,
    /// `last_kept / first_dropped`; infinite when what was dropped is exactly zero, or nothing was dropped.
    pub gap: f64,
    /// Number of values dropped.
    pub dropped: usize,
}

impl RankDecision {
    /// Whether the data themselves decide: a gap of at least 1000, or nothing dropped and the last value kept well
    /// above the tolerance.
    pub fn is_clear(&self) -> bool {
        const CLEAR: f64 = 1e3;
        if self.dropped == 0 {
            self.rank == 0 || self.last_kept >= CLEAR * self.tolerance
        } else {
            self.gap >= CLEAR
        }
    }
}

/// Decides the rank of a `rows` × `cols` matrix from its singular values (or pivots), largest first. At most
/// min(rows, cols) of them count.
pub fn decide_rank(values: &[f64], rows: usize, cols: usize, rule: RankRule) -> RankDecision {
    let top = values.first().copied().unwrap_or(0.0);
    let limit = rows.min(cols).min(values.len());
    let default = rows.max(cols) as f64 * f64::EPSILON * top;
    let tolerance = match rule {
        RankRule::Default => default,
        RankRule::Relative(r) => r * top,
        RankRule::Absolute(a) => a,
        RankRule::WidestGap { floor, ceiling, least } => {
            widest_gap(&values[..limit], floor * top, ceiling * top, least).unwrap_or(default)
        }
    };
    // A value of zero is dropped even with a tolerance of zero; values need not fall strictly (pivots), so count the
    // leading run.
    let rank = values[..limit].iter().take_while(|d| **d > tolerance).count();
    let last_kept = if rank > 0 { values[rank - 1] } else { 0.0 };
    let first_dropped = values.get(rank).copied().filter(|_| rank < cols).unwrap_or(0.0);
    let gap = if first_dropped > 0.0 { last_kept / first_dropped } else { f64::INFINITY };
    RankDecision { rank, tolerance, last_kept, first_dropped, gap, dropped: cols - rank }
}

/// A cut in the middle (geometric) of the widest gap whose upper side is above the floor and lower side below the ceiling.
fn widest_gap(values: &[f64], floor: f64, ceiling: f64, least: f64) -> Option<f64> {
    let mut best: Option<(f64, f64)> = None;
    for pair in values.windows(2) {
        let (above, below) = (pair[0], pair[1].max(f64::MIN_POSITIVE));
        if above <= floor || below > ceiling {
            continue;
        }
        let ratio = above / below.max(floor);
        if ratio >= least && best.is_none_or(|(r, _)| ratio > r) {
            best = Some((ratio, above.sqrt() * below.max(floor).sqrt()));
        }
    }
    best.map(|(_, cut)| cut)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_is_reported() {
        let d = decide_rank(&[10.0, 2.0, 1e-15, 1e-16], 100, 4, RankRule::Default);
        assert_eq!((d.rank, d.dropped), (2, 2));
        assert!((d.gap - 2e15).abs() < 1e3 && d.is_clear());
        let d = decide_rank(&[1.0, 1e-9, 1e-10], 100, 3, RankRule::Relative(5e-10));
        assert_eq!(d.rank, 2);
        assert!(!d.is_clear(), "a gap of ten decides nothing");
    }

    #[test]
    fn full_rank_zero_and_empty() {
        let d = decide_rank(&[3.0, 1.0], 10, 2, RankRule::Default);
        assert!(d.is_clear() && d.gap.is_infinite() && d.first_dropped.abs() < f64::MIN_POSITIVE);
        let barely = decide_rank(&[1.0, 1e-14], 10, 2, RankRule::Default);
        assert!(barely.rank == 2 && !barely.is_clear());
        let zero = decide_rank(&[0.0, 0.0], 10, 2, RankRule::Default);
        assert_eq!((zero.rank, zero.dropped), (0, 2));
        assert_eq!(decide_rank(&[], 0, 3, RankRule::Default).rank, 0);
        // Three values of a 2 × 3 matrix: the third is round-off of the method, whatever its size.
        assert_eq!(decide_rank(&[1.0, 0.5, 1e-3], 2, 3, RankRule::Default).rank, 2);
    }

    #[test]
    fn the_widest_gap_decides_between_floor_and_ceiling() {
        let rule = RankRule::WidestGap { floor: 1e-12, ceiling: 1e-4, least: 100.0 };
        let d = decide_rank(&[1.0, 0.1, 1e-2, 1e-9, 5e-10], 50, 5, rule);
        assert_eq!(d.rank, 3);
        let smooth = decide_rank(&[1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5], 50, 6, rule);
        assert_eq!(smooth.rank, 6, "no gap, so the default rule");
        assert!(rule.validate().is_ok() && RankRule::Relative(2.0).validate().is_err());
    }
}
