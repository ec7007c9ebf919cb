//! Progress of a discovery.

use crate::conclude::diagnosis::Diagnosis;

/// Progress of a discovery.
#[derive(Debug, Clone)]
pub enum Progress {
    /// Fitting the declared model.
    Fitting,
    /// Screening all candidates, with this number of findings in the model.
    Screening(usize),
    /// A candidate passed the tests of the linearised problem; its name.
    Found(String),
    /// The interim result after each finding, for a caller that may interrupt the search: fitted to the
    /// training rows, without competing hypotheses.
    Interim(Box<Diagnosis>),
    /// Reconsidering earlier findings.
    Reconsidering,
    /// Comparing the enlarged model with the declared one on unseen data.
    Checking,
    /// Evaluating the result on the held-out test set.
    Judging,
}
