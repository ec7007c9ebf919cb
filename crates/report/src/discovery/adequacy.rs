//! Whether the model is adequate: repeatability limit, lack of fit, unexplained residual, withdrawn findings.

use serde::{Deserialize, Serialize};
use truepose_discover::{Check, Diagnosis, FloorSource, Withdrawn};
use truepose_errormodel::Visits;
use truepose_identify::Repeats;

/// Lack of fit against repeated pose measurements.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LackOfFitSummary {
    /// Which estimate of the noise the significance is based on.
    pub against: NoiseReference,
    /// Pure error: 3-D RMS of repeated pose measurements, mm.
    pub pure_error_mm: Option<f64>,
    /// p-value of the declared model.
    pub before: Option<f64>,
    /// p-value with all findings.
    pub after: Option<f64>,
}

/// Which estimate of the noise a significance is based on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NoiseReference {
    /// Repeated pose measurements of the same configurations (pure error).
    Repeats,
    /// The residual itself, by a rotation test.
    Rotations,
}

/// The residual that no effect of the model explains.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UnexplainedSummary {
    /// Whether it is significant.
    pub significant: bool,
    /// 3-D RMS beyond the repeatability limit, mm; none where no estimate of that is known.
    #[serde(default)]
    pub rms_mm: Option<f64>,
    /// Its 95 % interval, mm.
    #[serde(default)]
    pub ci95_mm: Option<[f64; 2]>,
    /// Its fraction of the residual variance of the declared model, signed; none where no estimate of the limit is known.
    pub share_of_variance: Option<f64>,
    /// Its 95 % interval.
    #[serde(default)]
    pub share_ci95: Option<[f64; 2]>,
    /// 3-D RMS of the residual with what the parameters of the model took from it given back, mm.
    #[serde(default)]
    pub residual_rms_mm: Option<f64>,
    /// Whether the held-out error is far beyond the repeatability limit, so that the model is not called adequate.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub held_out_beyond: bool,
    /// p-value of the lack of fit against the repeatability limit; none where that does not come from poses.
    #[serde(default)]
    pub lack_of_fit_p: Option<f64>,
    /// Smallest family-wise p-value of the last screening.
    pub p_value: f64,
}

impl LackOfFitSummary {
    pub(super) fn new(found: &Diagnosis) -> Self {
        let p = |repeats: &Option<Repeats>| {
            repeats.as_ref().and_then(|r| r.lack_of_fit.as_ref()).map(|l| l.p_value)
        };
        let repeats = found.repeats_before.as_ref();
        LackOfFitSummary {
            against: if repeats.is_some() { NoiseReference::Repeats } else { NoiseReference::Rotations },
            pure_error_mm: repeats.map(|r| r.rms * 1e3),
            before: p(&found.repeats_before),
            after: p(&found.repeats_after),
        }
    }
}

impl UnexplainedSummary {
    pub(super) fn new(found: &Diagnosis) -> Self {
        let unexplained = &found.unexplained;
        UnexplainedSummary {
            significant: unexplained.significant,
            rms_mm: unexplained.rms.map(|rms| 1e3 * rms.value),
            ci95_mm: unexplained.rms.map(|rms| rms.ci95.map(|end| 1e3 * end)),
            share_of_variance: unexplained.share_of_variance.map(|share| share.value),
            share_ci95: unexplained.share_of_variance.map(|share| share.ci95),
            residual_rms_mm: unexplained.residual.map(|rms| 1e3 * rms),
            held_out_beyond: unexplained.held_out_beyond,
            lack_of_fit_p: unexplained.lack_of_fit.map(|lack| lack.p_value),
            p_value: unexplained.p_value,
        }
    }
}

/// The repeatability limit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NoiseFloorSummary {
    /// Expected 3-D RMS of one new row if the model were perfect, mm; none when it is unknown.
    pub rms_mm: Option<f64>,
    /// Source of the estimate.
    pub source: FloorSource,
    /// Its 95 % interval, mm; none where the limit is unknown.
    pub ci95_mm: Option<[f64; 2]>,
    /// Lower bound, mm: stated accuracy of the instrument or scatter within a dwell, without the repeatability of the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_least_mm: Option<f64>,
    /// Upper bound, mm: from differences between neighbouring poses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_most_mm: Option<f64>,
    /// Independent differences between pose measurements behind it.
    #[serde(default)]
    pub repeats: usize,
    /// Poses to measure a second time for an interval of ± 25 %.
    #[serde(default)]
    pub missing_repeats: usize,
}

/// Factors with which stated standard deviations that exceed the scatter were multiplied.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StatedScaleSummary {
    /// Of positions.
    pub position: f64,
    /// Of orientations.
    pub orientation: f64,
}

impl StatedScaleSummary {
    pub(super) fn of(found: &Diagnosis) -> Option<Self> {
        let scale = found.stated_scale;
        let summary = StatedScaleSummary { position: scale.position, orientation: scale.orientation };
        (!scale.is_one()).then_some(summary)
    }
}

/// Findings that were withdrawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WithdrawnSummary {
    /// Check that they failed.
    pub check: Check,
    /// 3-D RMS of the declared model in that check, mm.
    pub declared_rms_mm: f64,
    /// The same with the findings, mm.
    pub enlarged_rms_mm: f64,
    /// Names of the findings.
    pub findings: Vec<String>,
}

/// Fewer pose measurements than a search needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct TooFewPoses {
    /// Pose measurements of the data.
    pub poses: usize,
    /// Identifiable parameters of the declared model.
    pub parameters: usize,
}

impl TooFewPoses {
    /// Pose measurements per identifiable parameter below which a search is not reliable.
    const PER_PARAMETER: usize = 3;

    pub(super) fn of(found: &Diagnosis) -> Option<Self> {
        let (poses, parameters) = (Visits::of(&found.data).len(), found.declared.reduction.rank());
        (poses < Self::PER_PARAMETER * parameters).then_some(TooFewPoses { poses, parameters })
    }

    /// One sentence for the user.
    pub fn sentence(&self) -> String {
        format!(
            "{} pose measurements are few for {} identifiable parameters: a search for further effects is reliable from \
             about {} pose measurements on.",
            self.poses,
            self.parameters,
            Self::PER_PARAMETER * self.parameters
        )
    }
}

impl NoiseFloorSummary {
    pub(super) fn new(found: &Diagnosis) -> Self {
        NoiseFloorSummary {
            rms_mm: found.noise_floor.rms.map(|rms| 1e3 * rms),
            source: found.noise_floor.source,
            ci95_mm: found.noise_floor.ci95.map(|ends| ends.map(|end| 1e3 * end)),
            at_least_mm: found.noise_floor.at_least.map(|rms| 1e3 * rms),
            at_most_mm: found.noise_floor.at_most.map(|rms| 1e3 * rms),
            repeats: found.noise_floor.repeats,
            missing_repeats: found.noise_floor.missing_repeats,
        }
    }
}

impl WithdrawnSummary {
    pub(super) fn new(withdrawn: &Withdrawn) -> Self {
        WithdrawnSummary {
            check: withdrawn.check,
            declared_rms_mm: 1e3 * withdrawn.declared,
            enlarged_rms_mm: 1e3 * withdrawn.enlarged,
            findings: withdrawn.findings.iter().map(|(candidate, _)| candidate.words()).collect(),
        }
    }
}
