//! Base and tool of a URDF: it describes the arm, and neither where the instrument stood nor which point of the tool it measured.

use crate::args::Robot;
use crate::failure::Failure;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, Placed};

/// Which of base and tool a description leaves open.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Undeclared {
    pub base: bool,
    pub tool: bool,
}

impl Undeclared {
    /// Of the robot of a run: both of a URDF, unless they are declared known.
    pub fn of(args: &Robot) -> Result<Self, Failure> {
        let urdf = args.robot.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("urdf"));
        let options = [("--base-known", "base", args.base_known), ("--tool-known", "tool", args.tool_known)];
        if let Some((option, table, _)) = options.iter().find(|(.., given)| *given && !urdf) {
            return Err(Failure::Input(format!(
                "{option} is for a URDF: {} states in [{table}] what is known (known = false where it is not)",
                args.robot.display()
            )));
        }
        Ok(Undeclared { base: urdf && !args.base_known, tool: urdf && !args.tool_known })
    }

    /// The robot for measurements of an instrument, with what is open as unknown; and that in words.
    pub fn unknown(self, chain: &Chain, data: &Dataset) -> Result<Option<(Chain, String)>, Failure> {
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
    pub fn opened(self, chain: &Chain) -> Result<Option<(Chain, String)>, Failure> {
        let invalid = |error: truepose_kinematics::ChainError| Failure::Input(error.to_string());
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

/// The robot of a run with what its description leaves open as unknown, where an instrument measured it; and that in words.
pub(super) fn installed(chain: Chain, args: &Robot, data: &Dataset) -> Result<(Chain, Vec<String>), Failure> {
    let opened = Undeclared::of(args)?.unknown(&chain, data)?;
    Ok(opened.map_or_else(|| (chain, Vec::new()), |(chain, words)| (chain, vec![words])))
}
