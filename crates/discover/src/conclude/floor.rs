//! The repeatability limit: what one new row would be off by if the model were perfect, and where that figure comes from.
//!
//! | source | figure | what it is |
//! | --- | --- | --- |
//! | [`FloorSource::Repeats`] | 3-D RMS of repeated poses about their mean, with its χ² interval | an estimate |
//! | [`FloorSource::Stated`] | √3 times the standard deviation that the instrument states | a lower bound: the robot's repeatability comes on top |
//! | [`FloorSource::Unknown`] | none | nothing tells it |
//!
//! The residual of a model is never its own limit: a cause that nobody has found is part of it. Source of the interval: ISO 3534-1; Draper and
//! Smith, *Applied Regression Analysis*, 3rd ed., §2.1 (pure error).

use crate::conclude::errors::Errors;
use crate::problem::observation::typical_sd;
use crate::termination::Stop;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use truepose_errormodel::Dataset;
use truepose_identify::Repeats;

/// Where the repeatability limit comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FloorSource {
    /// Pure error of repeated poses.
    Repeats,
    /// The instrument's stated accuracy: a lower bound.
    Stated,
    /// Nothing tells it.
    Unknown,
}

/// The 3-D RMS that a perfect model would leave of one new row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseFloor {
    /// m; none when nothing tells it.
    pub rms: Option<f64>,
    /// Where it comes from.
    pub source: FloorSource,
    /// Its 95 % interval, m; none of a bound.
    pub ci95: Option<[f64; 2]>,
}

/// Whether the model is enough.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Verdict {
    /// What is left is not more than a known limit lets expect.
    Adequate,
    /// Something is left that no effect of the model explains.
    Unexplained,
    /// No limit is known against which it could be decided.
    Undecided,
}

/// Level of the tests behind a verdict.
const LEVEL: f64 = 0.01;

impl NoiseFloor {
    /// From repeated poses where there are any, else from what the instrument states.
    pub(crate) fn of(repeats: Option<&Repeats>, data: &Dataset) -> Self {
        if let Some(repeats) = repeats.filter(|repeats| repeats.rms > 0.0) {
            let freedom = repeats.freedom as f64;
            let end = |share: f64| {
                let quantile = ChiSquared::new(freedom).map_or(f64::NAN, |law| law.inverse_cdf(share));
                repeats.rms * (freedom / quantile).sqrt()
            };
            let ci95 = [end(0.975), end(0.025)];
            let ci95 = ci95.iter().all(|v| v.is_finite()).then_some(ci95);
            return NoiseFloor { rms: Some(repeats.rms), source: FloorSource::Repeats, ci95 };
        }
        let stated = typical_sd(data);
        if stated > 0.0 {
            return NoiseFloor { rms: Some(3f64.sqrt() * stated), source: FloorSource::Stated, ci95: None };
        }
        NoiseFloor { rms: None, source: FloorSource::Unknown, ci95: None }
    }

    /// What it says of a model that leaves `after`, given why the search ended and how repeats judge the model.
    pub(crate) fn verdict(&self, stopped: Stop, repeats: Option<&Repeats>, after: &Errors) -> Verdict {
        let lack = repeats.and_then(|repeats| repeats.lack_of_fit.as_ref()).map(|lack| lack.p_value);
        if stopped != Stop::NothingLeft || lack.is_some_and(|p| p < LEVEL) {
            return Verdict::Unexplained;
        }
        let enough = match self.source {
            FloorSource::Repeats => lack.is_some(),
            // As good as the instrument alone: the robot adds nothing to be explained.
            FloorSource::Stated => self.rms.is_some_and(|rms| after.rms().0 <= rms),
            FloorSource::Unknown => false,
        };
        if enough { Verdict::Adequate } else { Verdict::Undecided }
    }

    /// (3-D RMS, signed share of the variance that the declared model left) beyond the limit; none where no estimate of the limit is known.
    pub(crate) fn beyond(&self, before: f64, after: f64) -> Option<(f64, f64)> {
        let floor = self.rms.filter(|_| self.source != FloorSource::Stated)?;
        let left = after * after - floor * floor;
        Some((left.max(0.0).sqrt(), left / (before * before).max(f64::MIN_POSITIVE)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_identify::LackOfFit;

    fn repeats(rms: f64, p_value: f64) -> Repeats {
        let lack_of_fit = Some(LackOfFit { f: 1.0, freedom: 100, p_value });
        Repeats { groups: 10, freedom: 30, rms, one_sided: true, lack_of_fit }
    }

    #[test]
    fn the_limit_of_repeats_has_the_interval_of_its_degrees_of_freedom() {
        let floor = NoiseFloor::of(Some(&repeats(1e-4, 0.5)), &Dataset::default());
        let [lower, upper] = floor.ci95.expect("thirty degrees of freedom");
        // χ²_30: 16.791 and 46.979.
        assert!((lower - 1e-4 * (30f64 / 46.979).sqrt()).abs() < 1e-9);
        assert!((upper - 1e-4 * (30f64 / 16.791).sqrt()).abs() < 1e-9);
    }

    #[test]
    fn without_repeats_and_a_stated_accuracy_nothing_is_decided() {
        let floor = NoiseFloor::of(None, &Dataset::default());
        assert_eq!((floor.rms, floor.source), (None, FloorSource::Unknown));
        let nothing = Errors::default();
        assert_eq!(floor.verdict(Stop::NothingLeft, None, &nothing), Verdict::Undecided);
        assert_eq!(floor.beyond(1.0, 0.5), None);
    }

    #[test]
    fn nothing_is_adequate_beside_a_significant_lack_of_fit() {
        let nothing = Errors::default();
        for (p, verdict) in [(0.5, Verdict::Adequate), (1e-6, Verdict::Unexplained)] {
            let repeats = repeats(1e-4, p);
            let floor = NoiseFloor::of(Some(&repeats), &Dataset::default());
            assert_eq!(floor.verdict(Stop::NothingLeft, Some(&repeats), &nothing), verdict);
            assert_eq!(floor.verdict(Stop::Limit, Some(&repeats), &nothing), Verdict::Unexplained);
        }
    }
}
