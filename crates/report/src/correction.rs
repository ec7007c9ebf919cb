//! What is done with the result of a fit.

use serde::{Deserialize, Serialize};

/// What is done with the result of a fit, from nothing on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Correction {
    /// Nothing: the robot stays as it is.
    #[default]
    None,
    /// The constants of the controller are corrected.
    Constants,
    /// Each command is corrected by the model.
    Commands,
}

impl Correction {
    /// All of them.
    pub const ALL: [Correction; 3] = [Correction::None, Correction::Constants, Correction::Commands];

    /// The robot under it.
    pub fn name(self) -> &'static str {
        match self {
            Correction::None => "as it is",
            Correction::Constants => "with constants",
            Correction::Commands => "if compensated",
        }
    }
}
