//! What is expected of a command.

use truepose_errormodel::Beyond;

/// The expected accuracy of a command.
pub(crate) struct Expected {
    /// Distance from the desired position within which the point lies with 95 % probability, m.
    pub within_95: f64,
    /// Distance of the nominal robot from there under this command, m.
    pub correction: f64,
    /// Whether the command is the model's; else it is the nominal robot's.
    pub corrected: bool,
    pub beyond: Vec<(Beyond, f64)>,
}
