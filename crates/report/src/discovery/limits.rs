//! What bounds a result: the repeatability limit, what did not hold, and how small the campaign is.

use serde::{Deserialize, Serialize};
use truepose_discover::{Check, Diagnosis, FloorSource};
use truepose_errormodel::Visits;

/// The repeatability limit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NoiseFloorSummary {
    /// Expected 3-D RMS of one new row if the model were perfect, mm; none when nothing tells it.
    pub rms_mm: Option<f64>,
    /// Where it comes from.
    pub source: FloorSource,
    /// Its 95 % interval, mm; none of a bound.
    pub ci95_mm: Option<[f64; 2]>,
}

/// Findings that did not hold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WithdrawnSummary {
    /// Where they failed.
    pub check: Check,
    /// 3-D RMS of the declared model there, mm.
    pub declared_rms_mm: f64,
    /// The same with the findings, mm.
    pub enlarged_rms_mm: f64,
    /// The findings, in words.
    pub findings: Vec<String>,
}

/// A campaign that is small for its model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct TooFewPoses {
    /// Poses of the data.
    pub poses: usize,
    /// Identifiable parameters of the declared model.
    pub parameters: usize,
}

impl TooFewPoses {
    /// Poses for each parameter below which a search is not to be relied upon.
    const FOR_EACH: usize = 3;

    pub(super) fn of(found: &Diagnosis) -> Option<Self> {
        let (poses, parameters) = (Visits::of(&found.data).len(), found.declared.reduction.rank());
        (poses < Self::FOR_EACH * parameters).then_some(TooFewPoses { poses, parameters })
    }

    /// In a sentence.
    pub fn words(&self) -> String {
        format!(
            "{} poses are few for {} identifiable parameters: a search for further effects is reliable from about {} poses on.",
            self.poses,
            self.parameters,
            Self::FOR_EACH * self.parameters
        )
    }
}
