//! Repeatability in joint space: numbers and the sentence about them.

use crate::wording::p_text;
use crate::wording::significant;
use serde::{Deserialize, Serialize};
use truepose_discover::JointRepeatability;

/// Standard deviations of the joints from one pose measurement to the next.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct JointRepeatabilitySummary {
    /// Of each turning joint, µrad; none where none scatters.
    pub turning_urad: Option<f64>,
    /// Of each sliding joint, µm; none where none scatters.
    pub sliding_um: Option<f64>,
    /// 3-D RMS of what they displace the targets by, mm.
    pub tool_mm: f64,
    /// p of joints that do not scatter.
    pub p_value: f64,
}

impl JointRepeatabilitySummary {
    /// In µrad, µm and mm.
    pub fn new(found: &JointRepeatability) -> Self {
        let positive = |sd: f64| (sd > 0.0).then_some(1e6 * sd);
        JointRepeatabilitySummary {
            turning_urad: positive(found.joints.turning),
            sliding_um: positive(found.joints.sliding),
            tool_mm: 1e3 * found.at_tool,
            p_value: found.p_value,
        }
    }

    /// In words.
    pub fn sentence(&self) -> String {
        let turning = self.turning_urad.map(|sd| format!("{} µrad (each turning joint)", significant(sd, 2)));
        let sliding = self.sliding_um.map(|sd| format!("{} µm (each sliding joint)", significant(sd, 2)));
        let each: Vec<String> = turning.into_iter().chain(sliding).collect();
        format!(
            "Repeatability in joint space: standard deviation {}, {} mm RMS at the targets ({}). Tests of \
             effects and the repeatability limit allow for it.",
            each.join(" and "),
            significant(self.tool_mm, 2),
            p_text(self.p_value)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_discover::JointNoise;

    #[test]
    fn only_joints_that_scatter_are_named() {
        let joints = JointNoise { turning: 2.04e-5, sliding: 0.0 };
        let one = JointRepeatability::known(joints, 4.2e-5, 1e-5);
        let summary = JointRepeatabilitySummary::new(&one);
        assert_eq!(summary.sliding_um, None);
        let sentence = summary.sentence();
        assert!(sentence.contains("20 µrad (each turning joint), 0.042 mm RMS"), "{sentence}");
        assert!(!sentence.contains("sliding"), "{sentence}");
    }
}
