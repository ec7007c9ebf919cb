//! What a search has come to.

use crate::accept::evidence::Refused;
use crate::accept::model::Model;
use crate::screen::untestable::Untestable;
use crate::termination::Stop;

/// What a search has come to, at its end or on the way.
#[derive(Clone)]
pub(crate) struct Outcome {
    pub model: Model,
    /// Candidates that won a contest and failed a test.
    pub refused: Vec<Refused>,
    /// Causes that this data cannot test beside the declared model.
    pub untestable: Vec<Untestable>,
    pub last: LastScreen,
    pub stopped: Stop,
}

/// The last screen of all candidates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LastScreen {
    /// Smallest family-wise p.
    pub p_value: f64,
    /// Likelihood-ratio statistic of one unknown that would have been significant.
    pub detectable_gain: f64,
}

impl Outcome {
    /// Before the search.
    pub fn of(model: Model) -> Self {
        Outcome {
            model,
            refused: Vec::new(),
            untestable: Vec::new(),
            last: LastScreen { p_value: 1.0, detectable_gain: f64::INFINITY },
            stopped: Stop::Interrupted,
        }
    }
}
