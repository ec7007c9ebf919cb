//! Where the fit has the robot's base and the tool of its measurements.

use super::geometry::constant_errors;
use crate::CompensateError;
use truepose_errormodel::{FittedModel, error_matrix};
use truepose_kinematics::{FrameId, Pose, ToolId};

/// Base and tool with their constant errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Installation {
    /// Robot base in the measurement frame, `B E_0`.
    pub base: Pose,
    /// Tool of the measurements in the last joint's frame, `tool · E_tool`.
    pub tool: Pose,
}

/// Base and tool of a fit.
///
/// # Errors
/// When the model does not fit its robot.
pub fn installation(fitted: &FittedModel) -> Result<Installation, CompensateError> {
    installation_of(fitted, ToolId::FIRST)
}

/// The same of one of several tools.
///
/// # Errors
/// When the model does not fit its robot.
pub fn installation_of(fitted: &FittedModel, tool: ToolId) -> Result<Installation, CompensateError> {
    let chain = fitted.chain();
    let constants = constant_errors(fitted)?;
    let error = |frame: FrameId| error_matrix(&constants.frame(frame));
    Ok(Installation {
        base: chain.base().pose * error(FrameId::BASE),
        tool: chain.tools()[tool.0].placed.pose * error(chain.frame_of_tool(tool)),
    })
}
