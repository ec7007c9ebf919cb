//! One candidate of a screen.

use crate::hypotheses::candidate::Candidate;
use crate::problem::projection::Score;
use std::sync::Arc;

/// A candidate and its score; none where the data cannot judge it.
pub(crate) struct Screened {
    pub candidate: Arc<Candidate>,
    pub score: Option<Score>,
    /// Whether it does anything at all to the measured numbers.
    pub acts: bool,
}
