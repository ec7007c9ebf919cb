//! A finding with its evidence.

use crate::accept::evidence::Evidence;
use crate::hypotheses::candidate::Candidate;

/// A find with what speaks for it and who lost against it.
#[derive(Debug, Clone)]
pub(crate) struct Accepted {
    pub candidate: Candidate,
    pub evidence: Evidence,
    /// Who lost against it: how much less likely each makes the data (−2 ln L and what its coefficients cost), the most likely first.
    pub rivals: Vec<(Candidate, f64)>,
    /// Causes without a name that did well when it was found.
    pub shortlist: Vec<Candidate>,
}
