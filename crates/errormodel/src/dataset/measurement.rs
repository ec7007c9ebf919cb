//! One measurement: the inputs of a row, and what was measured.

use truepose_kinematics::{Load, TargetId, ToolId};

/// One measured (or to be predicted) row, in SI units. What is not set was not measured, or is the same for all rows.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Measurement {
    /// One value for each movable joint, rad or m.
    pub joints: Vec<f64>,
    /// Position of the target in the measurement frame, m; NaN where it was not measured.
    pub position: [f64; 3],
    /// Orientation of the tool in the measurement frame, unit quaternion (w, x, y, z).
    pub orientation: Option<[f64; 4]>,
    /// Standard deviation of `position` as the instrument states it, m; NaN where it states none.
    pub position_sd: [f64; 3],
    /// Standard deviation of the orientation about x, y, z of the measurement frame, rad; NaN where none is stated.
    pub orientation_sd: [f64; 3],
    /// The measured target; none stands for the tool's origin.
    pub target: Option<TargetId>,
    /// The tool, of a row without a target.
    pub tool: ToolId,
    /// Number of the pose measurement (`visit`) to which the row belongs; of all rows or of none.
    pub visit: Option<u64>,
    /// The load.
    pub load: Load,
    /// When, s; of all rows or of none.
    pub time: Option<f64>,
    /// For each movable joint the direction in which it last moved, −1, 0 or +1; of all rows or of none.
    pub approach: Option<Vec<f64>>,
    /// One value for each channel of the data set.
    pub channels: Vec<f64>,
}

impl Measurement {
    /// At these joint values (one a movable joint, rad or m), nothing measured yet.
    pub fn at(joints: impl Into<Vec<f64>>) -> Self {
        Measurement {
            joints: joints.into(),
            position: [f64::NAN; 3],
            orientation: None,
            position_sd: [f64::NAN; 3],
            orientation_sd: [f64::NAN; 3],
            target: None,
            tool: ToolId::FIRST,
            visit: None,
            load: Load::None,
            time: None,
            approach: None,
            channels: Vec::new(),
        }
    }

    /// With a measured position, m, measurement frame.
    pub fn position(self, position: impl Into<[f64; 3]>) -> Self {
        Measurement { position: position.into(), ..self }
    }

    /// With a measured orientation of the tool, unit quaternion (w, x, y, z), measurement frame.
    pub fn orientation(self, quaternion: [f64; 4]) -> Self {
        Measurement { orientation: Some(quaternion), ..self }
    }

    /// With the standard deviation of the position that the instrument states, m.
    pub fn position_sd(self, sd: [f64; 3]) -> Self {
        Measurement { position_sd: sd, ..self }
    }

    /// With the standard deviation of the orientation that the instrument states, rad.
    pub fn orientation_sd(self, sd: [f64; 3]) -> Self {
        Measurement { orientation_sd: sd, ..self }
    }

    /// Of this target.
    pub fn target(self, target: impl Into<Option<TargetId>>) -> Self {
        Measurement { target: target.into(), ..self }
    }

    /// Of this tool's origin, or orientation.
    pub fn tool(self, tool: ToolId) -> Self {
        Measurement { tool, ..self }
    }

    /// Of the pose measurement (`visit`) with this number.
    pub fn visit(self, number: u64) -> Self {
        Measurement { visit: Some(number), ..self }
    }

    /// Under this load.
    pub fn load(self, load: Load) -> Self {
        Measurement { load, ..self }
    }

    /// At this time, s.
    pub fn time(self, seconds: f64) -> Self {
        Measurement { time: Some(seconds), ..self }
    }

    /// With these directions in which the joints last moved.
    pub fn approach(self, directions: impl Into<Vec<f64>>) -> Self {
        Measurement { approach: Some(directions.into()), ..self }
    }

    /// With these values of the data set's channels.
    pub fn channels(self, values: impl Into<Vec<f64>>) -> Self {
        Measurement { channels: values.into(), ..self }
    }
}
