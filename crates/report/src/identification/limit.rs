//! What limits the accuracy of an identified robot: its repeatability, an effect that the model lacks, or the data.

use super::IdentificationSummary;

impl IdentificationSummary {
    /// Whether repeats of poses show that the model lacks an effect: the lack of fit is significant, and the error at least a tenth larger
    /// than the repeatability.
    pub fn lacks_an_effect(&self) -> bool {
        let (Some(last), Some(repeats)) = (self.stages.last(), &self.repeats) else { return false };
        let held_out = last.test_set.or(last.held_out).unwrap_or(last.train);
        repeats.lack_of_fit.is_some_and(|l| l.p_value <= 0.05) && held_out.rms_mm >= 1.1 * repeats.rms_mm
    }
}

/// What limits the accuracy.
pub(super) fn limit(summary: &IdentificationSummary) -> String {
    let Some(last) = summary.stages.last() else { return String::new() };
    let held_out = last.test_set.or(last.held_out).unwrap_or(last.train);
    if let Some(repeats) = &summary.repeats {
        let repeatability = repeats.rms_mm;
        let ratio = held_out.rms_mm / repeatability.max(1e-12);
        let conclusion = if summary.data_check.in_doubt {
            "Whether the model is adequate cannot be decided with this data.".to_owned()
        } else if repeats.lack_of_fit.is_none_or(|l| l.p_value > 0.05) {
            "The lack of fit is not significant: the model is adequate.".to_owned()
        } else if ratio < 1.1 {
            "The error of the model is within 10 % of it.".to_owned()
        } else {
            format!(
                "The error of the model is {} times as large: the model lacks an effect.",
                crate::significant(ratio, 2)
            )
        };
        return format!(
            "Repeatability (pure error): {} mm RMS. {conclusion}",
            crate::significant(repeatability, 3)
        );
    }
    if summary.weak_directions > 0 && held_out.rms_mm > 1.3 * last.train.rms_mm {
        return "The error on held-out data is much larger than on the data of the fit: measure more, and more varied, \
                configurations."
            .into();
    }
    "Repeatability unknown: no configuration was measured twice, so that noise and missing effects are not distinguishable. \
     Repeat some pose measurements."
        .into()
}
