//! Candidates that were tested and not added, and hypotheses that the data cannot test.

use super::effects::BeforeAfter;
use serde::{Deserialize, Serialize};
use truepose_discover::{Diagnosis, Place, Refused, Untestable};

/// A candidate that was tested and not added.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RefusedSummary {
    /// Family of the candidate.
    pub family: String,
    /// Where it acts.
    #[serde(flatten)]
    pub place: Place,
    /// Reason of the rejection.
    pub reason: String,
    /// Family-wise p-value of the resampling test.
    pub p_value: f64,
    /// Cross-validated RMS without and with the candidate, mm.
    pub cross_validated_rms_mm: BeforeAfter,
    /// Selection frequency: fraction of half-samples in which the candidate is selected.
    pub stability: f64,
}

/// A hypothesis that this data cannot test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UntestableSummary {
    /// Family of the candidate.
    pub family: String,
    /// Where it acts.
    #[serde(flatten)]
    pub place: Place,
    /// Fraction of its effect that the declared model does not absorb.
    pub share: f64,
    /// Information on its best direction, in inverse squares of its prior standard deviation; below one it is not testable.
    #[serde(default)]
    pub information: f64,
    /// 3-D RMS that would be detected with 80 % probability, mm; none when it has no effect on this data.
    pub detectable_rms_mm: Option<f64>,
    /// What to measure to make it testable.
    #[serde(default)]
    pub advice: String,
}

impl RefusedSummary {
    pub(super) fn new(refused: &Refused) -> Self {
        RefusedSummary {
            family: refused.candidate.family.word().into(),
            place: refused.candidate.place.clone(),
            reason: super::meaning::rejection(refused.doubt).into(),
            p_value: refused.evidence.p_value,
            cross_validated_rms_mm: super::effects::cross_validated(&refused.evidence),
            stability: refused.evidence.stability,
        }
    }

    /// Family and place, e.g. `backlash a1`.
    pub fn name(&self) -> String {
        format!("{} {}", self.family, self.place.words()).trim_end().to_owned()
    }
}

impl UntestableSummary {
    pub(super) fn new(untestable: &Untestable, found: &Diagnosis) -> Self {
        UntestableSummary {
            family: untestable.family.word().into(),
            place: untestable.place.clone(),
            share: untestable.share,
            information: untestable.information,
            detectable_rms_mm: untestable.detectable.map(|d| d * 1e3),
            advice: super::advice::advice(untestable, found),
        }
    }

    /// Family and place, e.g. `link_compliance a2`.
    pub fn name(&self) -> String {
        format!("{} {}", self.family, self.place.words()).trim_end().to_owned()
    }
}
