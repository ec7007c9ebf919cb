//! A pose of the program in its frame, and why one stays.

use super::correction::Outcome;
use crate::program::Branch;
use truepose_kinematics::{Pose, ToolId};

/// Why a point stays as it is.
pub(super) struct Stays {
    pub(super) outcome: Outcome,
    pub(super) reason: String,
}

impl From<String> for Stays {
    fn from(reason: String) -> Stays {
        Stays { outcome: Outcome::Refused, reason }
    }
}

/// A pose of the program with what it is in.
pub(super) struct Placed {
    pub(super) pose: Pose,
    /// `K · F`.
    pub(super) before: Pose,
    /// `G · X`.
    pub(super) behind: Pose,
    /// Both as they really are; of a frame on a positioner where its axes are known to be.
    pub(super) real: [Pose; 2],
    /// The positioner's tool that carries the frame, and the frame in its axes.
    pub(super) on: Option<(ToolId, Pose)>,
    pub(super) branch: Branch,
    /// Whether the branch is that of the joints.
    pub(super) stated: bool,
}

impl Placed {
    /// The nominal flange of the program, in the base of the description.
    pub(super) fn flange(&self) -> Pose {
        self.before * self.pose * self.behind.inverse()
    }

    /// The flange that brings the real tool to the point in the real frame.
    pub(super) fn meant(&self) -> Pose {
        let [before, behind] = self.real;
        before * self.pose * behind.inverse()
    }
}
