//! State of a search.

use crate::accept::evidence::Refused;
use crate::accept::model::Model;
use crate::problem::joint_noise::JointRepeatability;
use crate::screen::untestable::Untestable;
use crate::termination::Termination;

/// State of a search, after each finding or at the end.
#[derive(Clone)]
pub(crate) struct Outcome {
    pub model: Model,
    /// Candidates that had the best score and failed a test.
    pub refused: Vec<Refused>,
    /// Families and places that this data cannot test with the declared model in place.
    pub untestable: Vec<Untestable>,
    pub last: LastScreen,
    pub stopped: Termination,
    /// Repeatability in joint space, where it is significant.
    pub joints: Option<JointRepeatability>,
}

/// Result of the last screen of all candidates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LastScreen {
    /// Smallest family-wise p-value.
    pub p_value: f64,
    /// Score statistic of a candidate with one degree of freedom that would have been significant at α.
    pub detectable_gain: f64,
}

impl Outcome {
    /// State before the search.
    pub fn of(model: Model) -> Self {
        Outcome {
            model,
            refused: Vec::new(),
            untestable: Vec::new(),
            last: LastScreen { p_value: 1.0, detectable_gain: f64::INFINITY },
            stopped: Termination::Interrupted,
            joints: None,
        }
    }
}
