//! Frames that a positioner carries: they are in the axes of a tool of the fit that the external axes alone carry.

use super::external::{External, carries};
use super::frames::same;
use super::options::CorrectOptions;
use crate::ControllerError;
use truepose_kinematics::{Chain, ToolId};

/// Such frames with their tools.
#[derive(Debug, Clone, Default)]
pub(super) struct Work(Vec<(String, ToolId)>);

impl Work {
    /// # Errors
    /// When a tool is not there or the robot itself carries it, or a frame is named twice or was taught.
    pub(super) fn new(
        chain: &Chain,
        external: &External,
        options: &CorrectOptions,
    ) -> Result<Work, ControllerError> {
        let mut all: Vec<(String, ToolId)> = Vec::new();
        for (name, tool) in &options.work {
            let refused = |words: String| ControllerError::Option(format!("--work {name}={tool}: {words}"));
            let Some(id) = chain.tool_named(tool) else {
                let known: Vec<&str> = chain.tools().iter().map(|tool| tool.name.as_str()).collect();
                return Err(refused(format!(
                    "the fit has no tool `{tool}` (its tools: {})",
                    known.join(", ")
                )));
            };
            let own = external.robot.iter().find(|&&k| carries(chain, k, id));
            if let Some(&k) = own {
                let joint = &chain.joint(chain.movable()[k]).name;
                return Err(refused(format!(
                    "{joint} carries `{tool}` and is no external axis (--external)"
                )));
            }
            if all.iter().any(|(other, _)| same(other, name)) {
                return Err(refused("the frame is named twice".into()));
            }
            if options.taught.iter().any(|taught| same(&taught.name, name)) {
                return Err(refused("a frame on a positioner cannot be --taught".into()));
            }
            all.push((name.clone(), id));
        }
        Ok(Work(all))
    }

    /// The tool on which a frame is.
    pub(super) fn of(&self, name: Option<&str>) -> Option<ToolId> {
        let name = name?;
        self.0.iter().find(|(other, _)| same(other, name)).map(|(_, tool)| *tool)
    }
}
