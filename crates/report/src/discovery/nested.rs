//! Nested cross-validation of the whole search.

use super::gain::GainSummary;
use crate::PositionStatistics;
use serde::{Deserialize, Serialize};
use truepose_discover::{HeldOut, Nested};

/// Nested cross-validation: the whole search, run once for each fold with that fold left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NestedSummary {
    /// How the folds were made.
    pub folds: String,
    /// With the declared model.
    pub before: PositionStatistics,
    /// With the findings of each run.
    pub after: PositionStatistics,
    /// By how much the findings reduce the error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<GainSummary>,
    /// Names of the findings of each run.
    pub found: Vec<Vec<String>>,
    /// Position errors of each run on the fold that it left out.
    #[serde(default)]
    pub after_by_fold: Vec<PositionStatistics>,
}

impl NestedSummary {
    /// Summary of nested cross-validation; `folds` names how the folds were made.
    pub fn new(nested: &Nested, folds: String) -> Self {
        let intervals = nested.intervals.as_ref();
        NestedSummary {
            folds,
            before: PositionStatistics::from(nested.before).with_interval(intervals.map(|i| i.before)),
            after: PositionStatistics::from(nested.after).with_interval(intervals.map(|i| i.after)),
            gain: intervals.and_then(|i| GainSummary::new(i, HeldOut::NestedFolds)),
            found: nested.runs.iter().map(|run| run.findings.clone()).collect(),
            after_by_fold: nested.runs.iter().map(|run| run.errors().into()).collect(),
        }
    }
}
