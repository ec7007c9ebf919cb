//! Commands of one hand in the axes of another one: which hand, and what accuracy is expected.
//!
//! ```text
//! cov(p − p_o),   p_o = T_other X_d: a point of the other hand, where the pose is meant
//! ```

use super::expected::Expected;
use crate::beyond;
use crate::error::WorkflowError;
use std::path::Path;
use truepose_compensate::{Command, CompensateError, Status, radius_95};
use truepose_errormodel::{Aim, Coverage, FittedModel, RobotPoint};
use truepose_io::Poses;
use truepose_kinematics::nalgebra::Matrix3;
use truepose_kinematics::{Conditions, SEEN, Target, TargetId, ToolId};

/// The tool of a name, in whose axes these poses can be; a warning where its orientation is only declared.
///
/// # Errors
/// When there is no such tool, the poses have no joints, or one is of that tool itself.
pub fn relative_to(
    name: &str,
    fitted: &FittedModel,
    poses: &Poses,
    file: &Path,
) -> Result<(ToolId, Option<String>), WorkflowError> {
    const OPTION: &str = "relative-to";
    let chain = fitted.chain();
    let Some(other) = chain.tool_named(name) else {
        let names: Vec<&str> = chain.tools().iter().map(|tool| tool.name.as_str()).collect();
        let words = format!("the robot has no tool `{name}` (its tools: {})", names.join(", "));
        return Err(WorkflowError::option(OPTION, words));
    };
    if !poses.seeded {
        let words = "--relative-to: joint columns are needed: they say where the other hand is";
        return Err(WorkflowError::Input(format!("{}: {words}", file.display())));
    }
    if let Some(row) = (0..poses.rows.len()).find(|&row| poses.rows.tool(row) == other) {
        let line = poses.rows.line.get(row).map_or(String::new(), |line| format!("{line}:"));
        let words = format!("the pose is one of `{name}` itself; in its own axes it stands still");
        return Err(WorkflowError::Input(format!("{}:{line} {words}", file.display())));
    }
    let declared = beyond::oriented(fitted).map_err(|words| WorkflowError::option(OPTION, words))?;
    let warning = declared.map(|_| {
        format!(
            "the data of the fit has no orientations: how `{name}` is turned, in whose axes the poses are, is as declared, and not verified"
        )
    });
    Ok((other, warning))
}

/// What is expected of commands in the axes of another hand.
pub(super) fn expected(
    fitted: &FittedModel,
    poses: &Poses,
    commands: &[Command],
    other: ToolId,
) -> Result<Vec<Expected>, CompensateError> {
    let inputs = poses.rows.derived_for(fitted.model())?;
    let mut coverage = Coverage::new(fitted, &inputs.schema)?;
    let noise = Matrix3::identity() * fitted.noise.position_sd.powi(2);
    let described = fitted.chain().described_targets().len();
    let mut conditions = Conditions::default();
    let mut all = Vec::with_capacity(commands.len());
    for (row, command) in commands.iter().enumerate() {
        inputs.conditions_into(row, &mut conditions);
        conditions.joints.clear();
        conditions.joints.extend_from_slice(&command.joints);
        let (target, wanted) = (poses.rows.target[row], poses.rows.measured_position(row));
        let beyond = coverage.judge(&conditions, target).beyond;
        let hand = coverage.nominal(&Conditions { tool: other, ..conditions.clone() }, None);
        let meant = hand.inverse().apply(&coverage.nominal(&conditions, target).translation);
        let mut expected =
            Expected { within_95: f64::NAN, correction: (meant - wanted).norm(), corrected: true, beyond };
        if command.status == Status::Ok {
            let name = format!("{SEEN}{}", row + 1);
            let mut targets = fitted.chain().described_targets().to_vec();
            targets.push(Target { name, position: wanted, known: true, tool: other });
            let chain = fitted.chain().clone().with_targets(targets);
            let with_point = fitted.on(chain?)?;
            let aim = Aim { target, met: Some(RobotPoint::Target(TargetId(described))) };
            let (_, covariance) = with_point.bind(&inputs.schema)?.with_covariance(&conditions, aim);
            // The prediction is of the difference times [`Aim::CONTRAST`].
            expected.within_95 = radius_95(&(covariance / Aim::CONTRAST.powi(2) + noise));
        }
        all.push(expected);
    }
    Ok(all)
}
