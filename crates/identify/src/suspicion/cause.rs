//! Mistakes that a table may contain.

use serde::{Deserialize, Serialize};
use truepose_kinematics::JointKind;

/// What was probably done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "cause", rename_all = "snake_case")]
pub enum Cause {
    /// Two coordinates of the measured positions (0 x, 1 y, 2 z) are swapped: the frame is left-handed.
    SwappedAxes {
        /// One.
        a: usize,
        /// The other.
        b: usize,
    },
    /// One coordinate has the wrong sign: the frame is left-handed.
    MirroredAxis {
        /// Which.
        axis: usize,
    },
    /// Positions are in another unit; the factor puts it right.
    PositionUnit {
        /// Of all coordinates.
        factor: f64,
    },
    /// Joint values of one kind are in another unit; the factor puts it right.
    JointUnit {
        /// Turns or slides.
        kind: JointKind,
        /// Of their values.
        factor: f64,
    },
    /// Each joint's values are those of the joint so many places further on (around the end).
    ShiftedJoints {
        /// Places.
        by: usize,
    },
    /// The joints are in the order from tip to base.
    ReversedJoints,
    /// Two joints' columns (numbers of movable joints) are swapped.
    SwappedJoints {
        /// One.
        a: usize,
        /// The other.
        b: usize,
    },
    /// A joint counts the other way.
    NegatedJoint {
        /// Which.
        joint: usize,
    },
    /// A joint's zero is elsewhere.
    OffsetJoint {
        /// Which.
        joint: usize,
        /// What has to be added, rad.
        by: f64,
    },
    /// Joint values are those of the visit before (`late`) or after.
    StaleJoints {
        /// Values of the visit before.
        late: bool,
    },
    /// Two targets' names are swapped.
    SwappedTargets {
        /// One.
        a: usize,
        /// The other.
        b: usize,
    },
    /// Two targets' names are swapped in some rows.
    SwappedLabels {
        /// One.
        a: usize,
        /// The other.
        b: usize,
        /// Numbers of these rows (0-based), in order.
        rows: Vec<usize>,
    },
    /// Some rows, and no others, are as if something else had been done to them.
    InSomeRows {
        /// Numbers of these rows (0-based), in order.
        rows: Vec<usize>,
        /// What was done there.
        mistake: Box<Cause>,
    },
    /// Some rows lie far from where all the others say.
    StrayRows {
        /// Numbers of these rows (0-based), the farthest first.
        rows: Vec<usize>,
    },
    /// The base is not where the description has it.
    BaseElsewhere,
}

/// A likely mistake, and what says so.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Suspicion {
    /// What was probably done.
    pub cause: Cause,
    /// 3-D RMS that the registration leaves with the table as it is, m; of single rows, how far the farthest is from where the others say.
    pub before: f64,
    /// With the mistake undone, m; of single rows, the RMS of the others.
    pub after: f64,
}
