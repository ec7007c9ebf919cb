//! Whether the model is adequate, and how much of the residual no effect explains.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | s², ν_s | variance of one row with what the unknowns took from it given back, and its degrees of freedom ([`ResidualVariance`]) | m² |
//! | f², ν_f | square of the repeatability limit, and its degrees of freedom | m² |
//! | b² | s² of the declared model | m² |
//! | h_l | lower end of the interval of the held-out error | m |
//!
//! ```text
//! unexplained    u² = s² − f²,   share (s² − f²)/b²                with their signs
//! interval       [u² − √((s² − s²_l)² + (f²_u − f²)²),  u² + √((s²_u − s²)² + (f² − f²_l)²)]        (Zou and Donner 2008)
//! adequate       lack of fit not significant,   (s²/f²) F_{0.975}(ν_f, ν_s) < 1 + 2²,   and   h²_l < (1 + 2²) f²
//! ```
//!
//! A model that poses of no fit or search contradict is not adequate, however small its residual is. The last line bounds what may be left: were the unexplained part twice the noise, the model would be called adequate in one case of forty.
//! A test with few repeats finds nothing significant, and alone would call every model adequate.

use crate::conclude::floor::{FloorSource, NoiseFloor, interval};
use crate::policy::Policy;
use crate::termination::Termination;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use truepose_identify::{LackOfFit, ResidualVariance};

/// Whether the model is adequate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Verdict {
    /// The residual is not significant against the repeatability limit, which is precise enough to show it.
    Adequate,
    /// Significant structure remains that no effect of the model explains.
    Unexplained,
    /// The limit is unknown, too uncertain, or only a bound, so that it cannot be decided.
    Undecided,
}

/// A figure with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
}

/// The residual beyond the repeatability limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unexplained {
    /// Whether the verdict is [`Verdict::Unexplained`].
    pub significant: bool,
    /// 3-D RMS of the residual of one row, m, with what the unknowns of the model took from it given back; `None` where too few
    /// observations are left.
    pub residual: Option<f64>,
    /// 3-D RMS beyond the repeatability limit, √(RMS² − limit²), m, zero where that is negative; `None` without an estimate of the limit.
    pub rms: Option<Estimate>,
    /// (RMS² − limit²) over the mean square of the declared model, with its sign; `None` without an estimate
    /// of the limit.
    pub share_of_variance: Option<Estimate>,
    /// Whether the held-out error is that far beyond the limit, so that the model is not called adequate.
    pub held_out_beyond: bool,
    /// Lack of fit against the limit; `None` where that does not come from poses.
    pub lack_of_fit: Option<LackOfFit>,
    /// Smallest family-wise p-value of the last screen.
    pub p_value: f64,
    /// Score statistic of a candidate with one degree of freedom that would have been significant at α.
    pub detectable_gain: f64,
}

/// Residual variances of the declared model and of the model with all findings.
#[derive(Clone, Copy)]
pub(crate) struct Variances {
    pub before: Option<ResidualVariance>,
    pub after: Option<ResidualVariance>,
}

/// What an effect without a word can pass for.
#[derive(Clone, Copy, Default)]
pub(crate) struct Doubts {
    /// Whether a scatter of the joints was estimated.
    pub joints_scatter: bool,
    /// Standard deviation in space of a significant wander over the order of the poses, m.
    pub wander: Option<f64>,
    /// Whether rows that are kept out have a payload or a stretch of the record in common.
    pub outliers_together: bool,
    /// 95 % interval of the held-out error, 3-D RMS, m.
    pub unseen: Option<[f64; 2]>,
}

/// Verdict and unexplained part; `p_value` and `detectable_gain` are those of the last screen. Where the joints' own scatter was estimated,
/// the model is called adequate with as many repeats as a limit needs only: what an effect leaves can pass for scatter, and fewer do not show it.
/// Nor is it where rows that are kept out have a payload or a stretch of the record in common, which nothing explains, nor where the
/// larger part of what repeats scatter by is a wander over the order of the poses ([`wanders`]).
pub(crate) fn verdict(
    floor: &NoiseFloor,
    stopped: Termination,
    variances: Variances,
    (p_value, detectable_gain): (f64, f64),
    doubts: Doubts,
    policy: &Policy,
) -> (Verdict, Unexplained) {
    let left = variances.after;
    let lack_of_fit = left.zip(floor.pure.as_ref()).map(|(left, pure)| left.lack_of_fit(pure));
    let lacks = lack_of_fit.is_some_and(|lack| lack.p_value < policy.verdict_level);
    let beyond_unseen = doubts.unseen.is_some_and(|unseen| mispredicts(unseen, floor, policy));
    let doubted = (doubts.joints_scatter && floor.missing_repeats > 0)
        || wanders(doubts.wander, floor)
        || doubts.outliers_together
        || beyond_unseen;
    let decided = if stopped == Termination::Interrupted {
        Verdict::Undecided
    } else if stopped != Termination::NothingLeft || lacks {
        Verdict::Unexplained
    } else if floor.is_estimate() && left.is_some_and(|left| small(&left, floor, policy)) && !doubted {
        Verdict::Adequate
    } else {
        Verdict::Undecided
    };
    let square = left.and_then(|left| beyond(&left, floor));
    let declared = variances.before.map(|before| before.rms * before.rms).filter(|b| *b > 0.0);
    let root = |v: f64| v.max(0.0).sqrt();
    let unexplained = Unexplained {
        significant: decided == Verdict::Unexplained,
        residual: left.map(|left| left.rms),
        rms: square.map(|u| Estimate { value: root(u.value), ci95: u.ci95.map(root) }),
        share_of_variance: square
            .zip(declared)
            .map(|(u, b)| Estimate { value: u.value / b, ci95: u.ci95.map(|end| end / b) }),
        held_out_beyond: beyond_unseen,
        lack_of_fit,
        p_value,
        detectable_gain,
    };
    (decided, unexplained)
}

/// Whether a wander has more than half of the variance of the repeatability limit. Repeats that lie far apart in the order of the poses then
/// scatter by what a drift or a jump of the instrument does, and agree with any residual that it leaves.
fn wanders(wander: Option<f64>, floor: &NoiseFloor) -> bool {
    wander.zip(floor.rms).is_some_and(|(wander, rms)| wander * wander > 0.5 * rms * rms)
}

/// Whether the held-out error, with 97.5 % confidence, has more than [`Policy::adequate_margin`] times the noise beside it.
fn mispredicts([least, _]: [f64; 2], floor: &NoiseFloor, policy: &Policy) -> bool {
    floor.rms.is_some_and(|rms| (least / rms).powi(2) > 1.0 + policy.adequate_margin.powi(2))
}

/// Whether the unexplained part is below [`Policy::adequate_margin`] times the noise, with 97.5 % confidence.
fn small(left: &ResidualVariance, floor: &NoiseFloor, policy: &Policy) -> bool {
    let Some(rms) = floor.rms else { return false };
    let ratio = (left.rms / rms).powi(2);
    // What an instrument states has no degrees of freedom.
    let freedom = floor.pure.as_ref().map_or(1e6, |pure| pure.freedom);
    let upper = FisherSnedecor::new(freedom, left.freedom).map_or(f64::INFINITY, |d| d.inverse_cdf(0.975));
    ratio * upper < 1.0 + policy.adequate_margin.powi(2)
}

/// s² − f² with its interval, m²; `None` without an estimate of the limit.
fn beyond(left: &ResidualVariance, floor: &NoiseFloor) -> Option<Estimate> {
    let rms = floor.rms?;
    let [s, f] = [left.rms * left.rms, rms * rms];
    let own = interval(left.freedom)?.map(|factor| s * factor * factor);
    let of_floor = match floor.source {
        FloorSource::Stated => [f; 2],
        _ => floor.ci95?.map(|end| end * end),
    };
    let value = s - f;
    let ci95 = [value - (s - own[0]).hypot(of_floor[1] - f), value + (own[1] - s).hypot(f - of_floor[0])];
    Some(Estimate { value, ci95 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A limit of a millimetre.
    fn stated(policy: &Policy) -> NoiseFloor {
        NoiseFloor {
            rms: Some(1e-3),
            source: FloorSource::Stated,
            ci95: Some([0.9e-3, 1.1e-3]),
            ..NoiseFloor::unknown(policy)
        }
    }

    #[test]
    fn repeats_that_scatter_by_a_wander_decide_nothing() {
        let policy = Policy::default();
        let floor = stated(&policy);
        assert!(!wanders(None, &floor));
        assert!(!wanders(Some(0.6e-3), &floor));
        assert!(wanders(Some(0.8e-3), &floor));
        assert!(!wanders(Some(0.8e-3), &NoiseFloor::unknown(&policy)));
    }

    #[test]
    fn a_model_that_unseen_poses_contradict_is_not_adequate() {
        let policy = Policy::default();
        let floor = stated(&policy);
        assert!(!mispredicts([0.9e-3, 1.2e-3], &floor, &policy));
        // Many unknowns on few poses: the error at others is larger, and that is no doubt.
        assert!(!mispredicts([1.5e-3, 4e-3], &floor, &policy));
        assert!(mispredicts([2.3e-3, 4e-3], &floor, &policy));
        assert!(!mispredicts([2.3e-3, 4e-3], &NoiseFloor::unknown(&policy), &policy));
    }
}
