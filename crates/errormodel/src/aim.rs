//! What the position of a row is of: a point of the robot, or the way between two points that met.
//!
//! ```text
//! c = p                                a point p
//! c = (p_a − p_b)/√2                   points a and b that met, c = 0, or were d apart along a unit vector u, uᵀc = d/√2
//! ```
//!
//! Where two points of the robot met, p_a = l and p_b = l, nobody knows l. The difference above is what is left of both equations when l is
//! eliminated by an orthogonal transformation: its noise is that of the position of one point, and its degrees of freedom are those of the contact.

use std::f64::consts::FRAC_1_SQRT_2;
use truepose_kinematics::{Chain, FrameId, TargetId, ToolId};

/// A point of the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RobotPoint {
    /// A target.
    Target(TargetId),
    /// The origin of a tool.
    Tool(ToolId),
}

impl RobotPoint {
    /// The tool that carries it.
    pub fn tool(self, chain: &Chain) -> ToolId {
        match self {
            RobotPoint::Target(target) => chain.targets().get(target.0).map_or(ToolId::FIRST, |t| t.tool),
            RobotPoint::Tool(tool) => tool,
        }
    }

    /// The target; none: the origin of the tool.
    pub fn target(self) -> Option<TargetId> {
        match self {
            RobotPoint::Target(target) => Some(target),
            RobotPoint::Tool(_) => None,
        }
    }

    /// The frame of its tool, and the target on it.
    pub(crate) fn on(self, chain: &Chain) -> (FrameId, Option<TargetId>) {
        (chain.frame_of_tool(self.tool(chain)), self.target())
    }
}

/// What the position of a row is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Aim {
    /// The target; none: the origin of the tool that the conditions name.
    pub target: Option<TargetId>,
    /// The point that it met: the position is then that of the first point relative to this one, times [`Aim::CONTRAST`].
    pub met: Option<RobotPoint>,
}

impl Aim {
    /// 1/√2: factor of the difference of two positions that has the noise of one.
    pub const CONTRAST: f64 = FRAC_1_SQRT_2;
}

impl From<Option<TargetId>> for Aim {
    fn from(target: Option<TargetId>) -> Self {
        Aim { target, met: None }
    }
}
