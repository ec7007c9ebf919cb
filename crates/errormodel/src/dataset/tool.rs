//! Which tool of the robot a row is about, where it has several.
//!
//! The tool of a row is a channel, [`TOOL`]: its number 0… in the order of the description. A row with a target is about the tool that carries
//! the target.

use super::table::Dataset;
use truepose_kinematics::{Chain, ToolId};

/// The channel of the tool's number. No file can have a column of this name, and no cause is looked for in it.
pub const TOOL: &str = "tool~";

impl Dataset {
    /// The number of each row's tool; none where the robot has one.
    pub fn tools(&self) -> Option<&[f64]> {
        self.schema.channel(TOOL).map(|k| self.channels[k].as_slice())
    }

    /// The tool of a row.
    pub fn tool(&self, row: usize) -> ToolId {
        // Numbers are small and whole.
        self.tools().map_or(ToolId::FIRST, |numbers| ToolId(numbers[row] as usize))
    }

    /// With these tools, one a row; a row that measured a target has that target's. Nothing changes for a robot with one tool.
    pub fn set_tools(&mut self, chain: &Chain, of_row: &[ToolId]) {
        let several = chain.tools().len() > 1;
        let tool = |(row, tool): (usize, &ToolId)| {
            self.target[row].and_then(|t| chain.targets().get(t.0)).map_or(*tool, |target| target.tool).0
                as f64
        };
        let numbers = several.then(|| of_row.iter().enumerate().map(tool).collect());
        self.set_numbers(TOOL, numbers);
    }
}
