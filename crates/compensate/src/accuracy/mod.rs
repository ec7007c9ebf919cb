//! The other direction: how far off a robot is at a pose, how well that is known, and a map of both over the workspace.

mod map;
mod prediction_interval;

pub(crate) use map::everything;
pub use map::{AccuracyMap, MapGrid, MapNode, MapOptions, accuracy_map};
pub use prediction_interval::{
    PredictedError, correction_helps, predicted_error, radius_95, radius_95_about,
};
