//! What a search has found before it ends.

use crate::campaign::Source;
use crate::error::WorkflowError;
use crate::provenance::searched;
use std::sync::Arc;
use truepose_discover::Diagnosis;
use truepose_errormodel::FittedModel;
use truepose_report::{DiscoverySettings, DiscoverySummary};

/// What a search has found so far.
#[derive(Debug)]
pub struct Interim {
    /// The findings.
    pub found: Box<Diagnosis>,
    /// What the rows were made from.
    pub source: Arc<Source>,
    pub(crate) settings: DiscoverySettings,
    pub(crate) solver: String,
    pub(crate) rows: usize,
}

impl Interim {
    /// Figures of the findings so far, and why there are no more.
    pub fn summary(&self, why: &str) -> DiscoverySummary {
        let summary = DiscoverySummary::new(&self.found, self.settings);
        DiscoverySummary {
            incomplete: Some(why.into()),
            ..summary.with_data_check(self.source.check.clone())
        }
    }

    /// The fit with the findings so far, marked as incomplete.
    ///
    /// # Errors
    /// When effects that need the order of the rows cannot be left out.
    pub fn fitted(&self, why: &str) -> Result<FittedModel, WorkflowError> {
        let mut fitted = self.found.fit.fitted.without_order()?;
        self.source.record(&mut fitted);
        searched(&mut fitted, &self.solver, self.rows, self.settings.seed, false);
        fitted.provenance.insert("incomplete".into(), why.into());
        Ok(fitted)
    }
}
