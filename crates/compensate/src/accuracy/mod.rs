//! The other direction: how far off a robot is at a pose, how well that is known, and a map of both over the workspace.

mod band;
mod map;

pub use band::{PredictedError, correction_helps, predicted_error, radius_95};
pub(crate) use map::everything;
pub use map::{AccuracyMap, MapGrid, MapNode, MapOptions, accuracy_map};
