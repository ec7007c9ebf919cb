//! Base and tool of a URDF: it describes the arm, and neither where the instrument stood nor which point of the tool it measured.

use crate::error::WorkflowError;
use std::path::Path;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, Placed};

/// Which of base and tool a description leaves open.
#[derive(Debug, Clone, Copy, Default)]
pub struct Undeclared {
    /// The base.
    pub base: bool,
    /// The tool.
    pub tool: bool,
}

impl Undeclared {
    /// Of the file of a robot: both of a URDF, unless they are declared known.
    ///
    /// # Errors
    /// When one is declared known of a file that states it itself.
    pub fn of(robot: &Path, [base_known, tool_known]: [bool; 2]) -> Result<Self, WorkflowError> {
        let urdf = robot.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("urdf"));
        let options = [("base-known", "base", base_known), ("tool-known", "tool", tool_known)];
        if let Some((option, table, _)) = options.into_iter().find(|(.., given)| *given && !urdf) {
            let words = format!(
                "only a URDF leaves it open: {} states in [{table}] what is known (known = false where it is not)",
                robot.display()
            );
            return Err(WorkflowError::option(option, words));
        }
        Ok(Undeclared { base: urdf && !base_known, tool: urdf && !tool_known })
    }

    /// The robot for measurements of an instrument, with what is open as unknown; and that in words.
    pub fn unknown(self, chain: &Chain, data: &Dataset) -> Result<Option<(Chain, String)>, WorkflowError> {
        let measured = |row: usize| {
            let pose = data.position[row].iter().any(|v| v.is_finite()) || data.orientation[row].is_some();
            pose && data.sensor(row).is_none() && data.landmark(row).is_none()
        };
        match (0..data.len()).any(measured) {
            true => self.opened(chain),
            false => Ok(None),
        }
    }

    /// The same where the measurements are known to be an instrument's.
    pub fn opened(self, chain: &Chain) -> Result<Option<(Chain, String)>, WorkflowError> {
        let invalid = |error: truepose_kinematics::ChainError| WorkflowError::Input(error.to_string());
        let mut chain = chain.clone();
        if self.base {
            let base = Placed { known: false, ..*chain.base() };
            chain = chain.with_base(base).map_err(invalid)?;
        }
        if self.tool {
            let tool = Placed { known: false, ..*chain.tool() };
            chain = chain.with_tool(tool).map_err(invalid)?;
        }
        let what = match (self.base, self.tool) {
            (false, false) => return Ok(None),
            (true, true) => "base and tool are",
            (true, false) => "the base is",
            (false, true) => "the tool is",
        };
        let words = format!(
            "A URDF states neither where the instrument stood nor which point of the tool it measured: {what} found from the data (the \
             options base-known and tool-known declare them known)."
        );
        Ok(Some((chain, words)))
    }
}
