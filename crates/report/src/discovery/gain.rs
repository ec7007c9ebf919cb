//! By how much the findings reduce the error on data that no choice has seen, and the errors where the model extrapolates.

use crate::statistics::interval_text;
use crate::{PositionStatistics, count, significant};
use serde::{Deserialize, Serialize};
use truepose_discover::{Diagnosis, Extrapolation, HeldOut, HeldOutIntervals, Part};

/// By how much the findings reduce the error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GainSummary {
    /// Where it was measured.
    pub on: HeldOut,
    /// RMS of the declared model less that of the final model, mm.
    pub rms_mm: f64,
    /// Its 95 % interval, mm: paired bootstrap over configurations.
    pub ci95_mm: [f64; 2],
    /// Fraction of the mean square error that the findings explain, signed.
    pub explained_share: f64,
    /// Its 95 % interval.
    pub explained_share_ci95: [f64; 2],
}

impl GainSummary {
    pub(super) fn new(intervals: &HeldOutIntervals, on: HeldOut) -> Option<Self> {
        let (gain, explained) = intervals.gain.zip(intervals.explained)?;
        Some(GainSummary {
            on,
            rms_mm: 1e3 * gain.value,
            ci95_mm: gain.ci95.map(|end| 1e3 * end),
            explained_share: explained.value,
            explained_share_ci95: explained.ci95,
        })
    }

    /// The gain with its interval.
    pub(crate) fn sentence(&self) -> String {
        let on = match self.on {
            HeldOut::NestedFolds => "in nested folds, each predicted by a search that has not seen it",
            HeldOut::Refits => "in cross-validation of the findings, which were selected with the same rows",
            _ => "on the held-out test set, which took no part in the selection of effects",
        };
        format!("Gain: {} mm{} {on}.", significant(self.rms_mm, 2), interval_text(Some(self.ci95_mm)))
    }
}

/// Which part of the data was left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PartName {
    /// The last 30 % in time.
    LastInTime,
    /// The ends of a joint's range.
    Region,
}

/// Errors on a part of the data without which the coefficients were estimated again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExtrapolationSummary {
    /// Which part.
    pub part: PartName,
    /// The joint of a region.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// Values of the joint below and above which the region lies, rad or m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outside: Option<[f64; 2]>,
    /// Pose measurements in the part.
    pub poses: usize,
    /// With the declared model.
    pub before: PositionStatistics,
    /// With the findings.
    pub after: PositionStatistics,
    /// RMS of the fit as it is written, which falls back to the declared model beyond its data, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_with_fallback_mm: Option<f64>,
}

impl ExtrapolationSummary {
    pub(super) fn new(found: &Diagnosis, of: &Extrapolation) -> Self {
        let (part, joint, outside) = match of.part {
            Part::Region { joint, outside } => {
                let name = found.fit.fitted.chain().joint(joint).name.clone();
                (PartName::Region, Some(name), Some(outside))
            }
            _ => (PartName::LastInTime, None, None),
        };
        ExtrapolationSummary {
            part,
            joint,
            outside,
            poses: of.poses,
            before: PositionStatistics::from(of.before).with_interval(of.ci95.map(|ends| ends[0])),
            after: PositionStatistics::from(of.after).with_interval(of.ci95.map(|ends| ends[1])),
            rms_with_fallback_mm: of.fallen_back.map(|rms| 1e3 * rms),
        }
    }

    /// The error, and a warning where it is much larger than that of random poses.
    pub(crate) fn sentence(&self, random: &PositionStatistics) -> String {
        let place = match (&self.part, &self.joint) {
            (PartName::Region, Some(joint)) => format!("At both ends of the range of {joint}"),
            _ => "On the last 30 % in time".into(),
        };
        let figure = format!(
            "{place}, left out of the fit ({}): {}.",
            count(self.poses, "pose measurement"),
            self.after.rms_text()
        );
        let fallback = match self.rms_with_fallback_mm.filter(|rms| *rms < 0.98 * self.after.rms_mm) {
            Some(rms) => format!(
                " Beyond its data the fit falls back to the declared model ({} mm there): {} mm.",
                significant(self.before.rms_mm, 3),
                significant(rms, 3)
            ),
            None => String::new(),
        };
        match self.exceeds(random) {
            true => format!(
                "{figure} That is {} times the error of random poses: the model interpolates better than it extrapolates.{fallback}",
                significant(self.after.rms_mm / random.rms_mm, 2)
            ),
            false => figure,
        }
    }

    /// Whether the error is more than 1.5 times that of random poses, and their intervals do not overlap.
    pub fn exceeds(&self, random: &PositionStatistics) -> bool {
        let apart = self.after.ci95_mm.zip(random.ci95_mm).is_some_and(|(own, other)| own[0] > other[1]);
        self.after.rms_mm > 1.5 * random.rms_mm && apart
    }
}
