//! Measurement campaign: poses in their order, with their loads.
//!
//! A campaign is made from a set of postures, loaded, put in order and put on the clock:
//!
//! ```
//! use truepose_simulate::Campaign;
//! use truepose_kinematics::samples;
//!
//! let robot = samples::heavy();
//! let campaign = Campaign::random(&robot, 40, 7)?          // a Latin hypercube within the limits
//!     .with_each_payload(&[0.0, 50.0], [0.0, 0.0, 0.2])    // each posture empty, then loaded
//!     .repeated(2)                                         // and all of that twice
//!     .shuffled(7);                                        // in no order that drift could hide behind
//! assert_eq!(campaign.visits.len(), 160);
//! # Ok::<(), truepose_simulate::SimulateError>(())
//! ```

mod channels;
mod order;
mod paper;
mod postures;
mod swept;

pub use channels::ChannelPlan;
pub use paper::{POUND, TREATMENT_POINT, payload_at_treatment_point};
pub(crate) use postures::{limits, variables};

use truepose_kinematics::{Load, TargetId};

/// One pose measurement (file key `visit`): a dwell of the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Visit {
    /// Values of the movable joints, rad or m.
    pub joints: Vec<f64>,
    /// Declared load of the tool.
    pub load: Load,
    /// Direction in which each movable joint last moved; none: from the visit before.
    pub approach: Option<Vec<f64>>,
    /// What is measured.
    pub task: Task,
}

/// What is measured in a visit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Task {
    /// Positions of the targets, by the instrument.
    #[default]
    Positions,
    /// What a thing of the cell observes. The joints of the visit are found with the real robot: a posture in which it touches or is seen.
    Observed {
        /// The thing, by its place in [`crate::Cell::things`].
        thing: usize,
        /// The target; none is the tool's origin. A camera in the cell observes all targets of its own.
        target: Option<TargetId>,
    },
}

/// Visits in the order in which they are made.
#[derive(Debug, Clone, PartialEq)]
pub struct Campaign {
    /// The visits.
    pub visits: Vec<Visit>,
    /// Targets measured at each visit; empty: all that the robot has, or its tool's origin.
    pub targets: Vec<Option<TargetId>>,
    /// Seconds from one visit to the next.
    pub visit_s: f64,
    /// Seconds from one target to the next.
    pub row_s: f64,
    /// When the first visit begins, s.
    pub start_s: f64,
    /// Pauses: before which visit, and how many seconds longer than usual.
    pub pauses: Vec<(usize, f64)>,
    /// Numeric columns besides those with a meaning.
    pub channels: Vec<ChannelPlan>,
}

impl Campaign {
    /// Visits of these postures, unloaded, half a minute each.
    pub fn of(postures: Vec<Vec<f64>>) -> Self {
        let visit = |joints| Visit { joints, load: Load::None, approach: None, task: Task::Positions };
        let visits = postures.into_iter().map(visit).collect();
        Campaign {
            visits,
            targets: Vec::new(),
            visit_s: 30.0,
            row_s: 2.0,
            start_s: 0.0,
            pauses: Vec::new(),
            channels: Vec::new(),
        }
    }

    /// With these columns besides those with a meaning.
    pub fn with_channels(mut self, channels: Vec<ChannelPlan>) -> Self {
        self.channels = channels;
        self
    }

    /// Seconds from the first visit's beginning to the last one's.
    pub fn duration_s(&self) -> f64 {
        self.times().last().map_or(0.0, |last| last - self.start_s)
    }

    /// When each visit begins, s.
    pub fn times(&self) -> Vec<f64> {
        let paused = |index: usize| -> f64 {
            self.pauses.iter().filter(|(before, _)| *before <= index).map(|(_, seconds)| seconds).sum()
        };
        (0..self.visits.len())
            .map(|index| self.start_s + self.visit_s * index as f64 + paused(index))
            .collect()
    }
}
