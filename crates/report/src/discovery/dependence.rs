//! Dependence of poses on those measured before: numbers and the sentence about them.

use crate::wording::p_text;
use crate::wording::significant;
use serde::{Deserialize, Serialize};
use truepose_discover::Dependence;

/// Dependence of the residuals of poses on those measured before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DependenceSummary {
    /// Correlation of a pose's residual with that of the next pose, of one axis.
    pub autocorrelation: f64,
    /// p of no dependence.
    pub p_value: f64,
    /// Standard deviation of the wander in space, mm; none where it is not significant.
    pub wander_mm: Option<f64>,
    /// Its time constant, s; none without a wander or a time.
    pub time_constant_s: Option<f64>,
    /// Its time constant in pose measurements, where the data has no time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_constant_poses: Option<f64>,
}

impl DependenceSummary {
    /// In mm.
    pub fn new(found: &Dependence) -> Self {
        DependenceSummary {
            autocorrelation: found.autocorrelation,
            p_value: found.p_value,
            wander_mm: found.wander.map(|wander| 1e3 * wander),
            time_constant_s: found.time_constant.filter(|_| found.timed),
            time_constant_poses: found.time_constant.filter(|_| !found.timed),
        }
    }

    /// The wander, where it has more than half of the variance of this limit, mm.
    pub(super) fn beyond_half(&self, limit_mm: Option<f64>) -> Option<String> {
        let (wander, limit) = (self.wander_mm?, limit_mm?);
        (wander * wander > 0.5 * limit * limit).then(|| significant(wander, 2))
    }

    /// What a reader can do.
    pub(super) fn advice(&self) -> &'static str {
        match self.time_constant_poses {
            Some(_) => {
                " The data has no time: drifts and jumps were searched in the order of the rows, which has to be that of measurement. \
                 With a column `time[s]` what follows a clock is searched, too."
            }
            None => "",
        }
    }

    /// What is significant, in words.
    pub fn sentence(&self) -> Option<String> {
        let wander = significant(self.wander_mm?, 2);
        let over = match (self.time_constant_s, self.time_constant_poses) {
            (Some(seconds), _) if seconds >= 90.0 => format!("{} min", significant(seconds / 60.0, 2)),
            (Some(seconds), _) => format!("{} s", significant(seconds, 2)),
            (None, Some(poses)) => format!("{} pose measurements", significant(poses, 2)),
            (None, None) => return None,
        };
        Some(format!(
            "The instrument or the robot wanders by {wander} mm RMS over {over} (autocorrelation of neighbouring poses {}, {}). \
             Tests of effects allow for it. An \
             effect that follows the order of the poses and is not in the model looks the same.",
            significant(self.autocorrelation, 2),
            p_text(self.p_value)
        ))
    }
}
