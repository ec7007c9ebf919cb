//! One measured row, as a placement sees it.

use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Pose, TargetId, ToolId};

/// One measured row: the nominal flange, what was measured, and of which target.
#[derive(Debug, Clone)]
pub(crate) struct Sight {
    /// Frame 0 ← flange.
    pub flange: Pose,
    /// Complete position, m.
    pub position: Option<Vector3<f64>>,
    /// Orientation of the tool.
    pub rotation: Option<Matrix3<f64>>,
    /// Which tool.
    pub tool: ToolId,
    /// Which target; none is the tool's origin.
    pub target: Option<TargetId>,
}
