//! An identification with its data.

use std::sync::Arc;
use truepose_errormodel::Dataset;
use truepose_identify::Identification;
use truepose_report::IdentificationSummary;

/// An identification with its data.
pub struct Identified {
    pub found: Identification,
    pub data: Arc<Dataset>,
    pub labels: Vec<i64>,
    pub summary: IdentificationSummary,
}
