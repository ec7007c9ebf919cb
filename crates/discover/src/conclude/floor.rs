//! The repeatability limit: expected 3-D RMS of one new row under a perfect model, with its source.
//!
//! It contains what repeats of a pose contain: the repeatability of the robot and the noise of the instrument, in the unit of the
//! held-out RMS beside which it stands. The first source that the data has is taken:
//!
//! | source | figure | what it is |
//! | --- | --- | --- |
//! | [`FloorSource::Repeats`] | pure error of repeated configurations | an estimate |
//! | [`FloorSource::NearRepeats`] | the same of neighbourhoods too small for any effect that is looked for to change in them, residuals of the model in place of positions (Christensen 1989) | an estimate |
//! | [`FloorSource::Differences`] | the same of wider neighbourhoods (Hall, Kay and Titterington 1990) | an upper bound: effects of short period are in it |
//! | [`FloorSource::Stated`] | what the instrument states, where the residual is no larger | a lower bound that the residual confirms |
//! | [`FloorSource::Unknown`] | none | |
//!
//! ```text
//! interval    RMS √(ν/χ²_{ν,0.975}) … RMS √(ν/χ²_{ν,0.025})              ν effective degrees of freedom
//! ```
//!
//! Where the instrument states less than the residual, the repeatability of the robot is missing, and the stated value is told as a lower bound
//! only ([`NoiseFloor::at_least`]); so is the scatter of several rows of one dwell. The residual of a model is never used as the limit: it
//! contains effects that are not in the model.

use crate::error::DiscoverError;
use crate::policy::Policy;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use truepose_errormodel::{Dataset, FittedModel};
use truepose_identify::{
    PureError, ResidualVariance, Residuals, exact_repeats, near_repeats, repeats_for, within_dwell,
};
use truepose_kinematics::{Chain, JointKind};

/// Where the repeatability limit comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FloorSource {
    /// Pure error of repeated configurations.
    Repeats,
    /// Pure error of nearly repeated configurations, corrected by the model.
    NearRepeats,
    /// Differences between neighbouring poses: an upper bound.
    Differences,
    /// The instrument's stated accuracy, which the residual does not exceed.
    Stated,
    /// Unknown.
    Unknown,
}

/// The repeatability limit: expected 3-D RMS of one new row under a perfect model.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseFloor {
    /// m; `None` when it is unknown.
    pub rms: Option<f64>,
    /// Where it comes from.
    pub source: FloorSource,
    /// Its 95 % confidence interval, m.
    pub ci95: Option<[f64; 2]>,
    /// Lower bound, m: the stated accuracy of the instrument, or the scatter of rows of one dwell. Neither contains the repeatability of the
    /// robot.
    pub at_least: Option<f64>,
    /// Upper bound, m: from differences between neighbouring poses.
    pub at_most: Option<f64>,
    /// Independent differences between pose measurements behind it.
    pub repeats: usize,
    /// Poses that have to be measured a second time for an interval of ± 25 %, beside those that were.
    pub missing_repeats: usize,
    /// The pure error behind it; `None` where it does not come from poses.
    pub(crate) pure: Option<PureError>,
}

/// The 95 % interval of an RMS with so many degrees of freedom, as factors.
pub(crate) fn interval(freedom: f64) -> Option<[f64; 2]> {
    let distribution = ChiSquared::new(freedom).ok()?;
    let ends = [0.975, 0.025].map(|share| (freedom / distribution.inverse_cdf(share)).sqrt());
    ends.iter().all(|v| v.is_finite()).then_some(ends)
}

impl NoiseFloor {
    /// The limit that nothing is known of.
    pub(crate) fn unknown(policy: &Policy) -> Self {
        NoiseFloor {
            rms: None,
            source: FloorSource::Unknown,
            ci95: None,
            at_least: None,
            at_most: None,
            repeats: 0,
            missing_repeats: repeats_for(wanted(policy)),
            pure: None,
        }
    }

    /// From the residuals of a model on data, and its residual variance. `weights`: of each row, so that all poses scatter alike. `trusted`: the stated standard deviations were not found too large.
    pub(crate) fn of(
        fitted: &FittedModel,
        (data, weights): (&Dataset, Option<&[f64]>),
        left: Option<&ResidualVariance>,
        trusted: bool,
        policy: &Policy,
    ) -> Result<Self, DiscoverError> {
        let residuals = Residuals::of(fitted, data)?;
        let mut alike = residuals.clone();
        for (residual, weight) in alike.position.iter_mut().zip(weights.unwrap_or_default()) {
            *residual *= *weight;
        }
        let pure = |groups: Vec<Vec<usize>>| PureError::of(&alike, data, &groups);
        let mut floor = NoiseFloor::unknown(policy);
        let stated = stated_rms(data).filter(|_| trusted);
        let dwell = within_dwell(&residuals, data).map(|(rms, _)| rms);
        floor.at_least = stated.into_iter().chain(dwell).reduce(f64::max);

        let wanted = wanted(policy);
        let better = |a: &PureError, b: &PureError| a.freedom > 1.5 * b.freedom;
        let exact = pure(exact_repeats(data));
        let near = |cycles: [f64; 2], share: f64| {
            let shares = [0, 1].map(|k| share * policy.near_share / cycles[k]);
            pure(near_repeats(data, &neighbourhood(fitted.chain(), data, shares)))
        };
        let enough = |pure: &PureError| pure.freedom >= policy.floor_freedom;
        let precise = |pure: &PureError| pure.freedom >= wanted;
        let exact_is_precise = exact.as_ref().is_some_and(precise);
        if !exact_is_precise {
            let beats = |close: &PureError| exact.as_ref().is_none_or(|exact| better(close, exact));
            // The narrowest neighbourhood with enough poses, else the widest: the narrower, the less of an effect is in it.
            let mut close = None;
            for share in [0.1, 0.3, 1.0] {
                close = near([policy.cycles_per_turn, policy.cycles_per_travel], share).or(close);
                if close.as_ref().is_some_and(precise) {
                    break;
                }
            }
            if let Some(close) = close.filter(|close| enough(close) && beats(close)) {
                return Ok(floor.from(FloorSource::NearRepeats, close, wanted));
            }
        }
        if let Some(exact) = exact.filter(enough) {
            return Ok(floor.from(FloorSource::Repeats, exact, wanted));
        }
        let wide = near([policy.difference_cycles; 2], 1.0);
        if let Some(wide) = wide.filter(precise) {
            let upper = interval(wide.freedom).map(|[_, upper]| upper * wide.rms);
            let floor = NoiseFloor { at_most: upper, ..floor };
            return Ok(floor.from(FloorSource::Differences, wide, wanted));
        }
        let confirmed = |stated: f64| {
            let left = left?;
            let [lower, upper] = interval(left.freedom)?.map(|factor| factor * left.rms);
            // Neither significantly more, nor so much that a fifth of it may be something else.
            (lower <= stated && stated <= upper && upper <= stated * policy.floor_precision.exp())
                .then_some([lower.min(stated), upper])
        };
        Ok(match stated.and_then(|stated| Some((stated, confirmed(stated)?))) {
            Some((rms, ci95)) => {
                NoiseFloor { rms: Some(rms), source: FloorSource::Stated, ci95: Some(ci95), ..floor }
            }
            None => floor,
        })
    }

    fn from(self, source: FloorSource, pure: PureError, wanted: f64) -> Self {
        let ci95 = interval(pure.freedom).map(|ends| ends.map(|factor| factor * pure.rms));
        let more = (repeats_for(wanted) as f64 * (1.0 - pure.freedom / wanted)).ceil().max(0.0);
        let missing_repeats =
            if source == FloorSource::Differences { self.missing_repeats } else { more as usize };
        let repeats = pure.contrasts;
        NoiseFloor { rms: Some(pure.rms), source, ci95, repeats, missing_repeats, pure: Some(pure), ..self }
    }

    /// Whether it is an estimate, or confirmed: so that a residual that it explains is noise.
    pub(crate) fn is_estimate(&self) -> bool {
        matches!(self.source, FloorSource::Repeats | FloorSource::NearRepeats | FloorSource::Stated)
    }
}

/// Degrees of freedom for the precision that is wanted: ν = (1.96/ln f)²/2, as the logarithm of an RMS has the variance 1/(2ν).
fn wanted(policy: &Policy) -> f64 {
    0.5 * (1.96 / policy.floor_precision).powi(2)
}

/// Largest differences of the joints of one neighbourhood, rad and m: these shares of a turn, and of the visited travel of a slide.
fn neighbourhood(chain: &Chain, data: &Dataset, [turn, travel]: [f64; 2]) -> Vec<f64> {
    let of = |(k, joint): (usize, &truepose_kinematics::JointId)| {
        let width = if chain.joint(*joint).kind == JointKind::Prismatic {
            let q = data.joints[k].iter();
            let ends = q.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &q| [a.min(q), b.max(q)]);
            (ends[1] - ends[0]).max(0.0) * travel
        } else {
            std::f64::consts::TAU * turn
        };
        width.max(data.dwell.tolerance(k))
    };
    chain.movable().iter().enumerate().map(of).collect()
}

/// RMS of the standard deviations of a row's position over the components that were measured, as the instrument states them, m; `None`
/// where it states nothing.
pub(crate) fn stated_rms(data: &Dataset) -> Option<f64> {
    let stated = |row: usize| {
        let own =
            (0..3).filter(|&axis| data.seen(row).position[axis]).map(|axis| data.position_sd[row][axis]);
        let own: Vec<f64> = own.collect();
        let all = !own.is_empty() && own.iter().all(|sd| sd.is_finite() && *sd > 0.0);
        all.then(|| own.iter().map(|sd| sd * sd).sum::<f64>())
    };
    let rows: Vec<f64> = (0..data.len()).filter_map(stated).collect();
    (!rows.is_empty()).then(|| (rows.iter().sum::<f64>() / rows.len() as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_that_of_chi_square() {
        let [lower, upper] = interval(30.0).expect("thirty degrees of freedom");
        // χ²_30: 16.791 and 46.979.
        assert!((lower - (30f64 / 46.979).sqrt()).abs() < 1e-5);
        assert!((upper - (30f64 / 16.791).sqrt()).abs() < 1e-5);
    }

    #[test]
    fn as_many_repeats_are_asked_for_as_the_precision_takes() {
        let policy = Policy::default();
        let freedom = wanted(&policy);
        let [lower, upper] = interval(freedom).expect("degrees of freedom");
        assert!(lower > 0.78 && upper < 1.32, "{lower} {upper}");
        assert_eq!(repeats_for(freedom), 15);
        assert_eq!(NoiseFloor::unknown(&policy).missing_repeats, 15);
    }
}
