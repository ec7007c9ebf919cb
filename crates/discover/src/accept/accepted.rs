//! A finding with its evidence.

use crate::accept::evidence::Evidence;
use crate::hypotheses::candidate::Candidate;

/// An accepted finding: the candidate, its evidence, and the hypotheses that it was preferred to.
#[derive(Debug, Clone)]
pub(crate) struct Accepted {
    pub candidate: Candidate,
    pub evidence: Evidence,
    /// Competing hypotheses, each with its difference in −2 ln L + coefficient penalty from the finding
    /// (positive: less likely); smallest difference first.
    pub competitors: Vec<(Candidate, f64)>,
    /// Unnamed candidates with high scores at the time of the finding; reconsideration tests them again.
    pub shortlist: Vec<Candidate>,
}
