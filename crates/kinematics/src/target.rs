//! A point that the instrument measures.

use crate::ToolId;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// How names of targets begin that a description does not have: of a single row, at the point that a camera on the robot sees.
pub const SEEN: &str = "seen~";

/// A measured point, carried by a tool.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Its name in the `target` column of the data.
    pub name: String,
    /// Nominal position in the tool frame, m.
    pub position: Vector3<f64>,
    /// False when the position is to be found from the data.
    pub known: bool,
    /// The tool that carries it.
    #[serde(default)]
    pub tool: ToolId,
}
