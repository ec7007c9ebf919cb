//! Logs: joints and positions that were recorded while the robot moved, and the standstills in them.

mod lag;
mod moving;
mod rows;
mod standstills;
mod streams;

pub use moving::Moving;
pub use rows::{DwellOptions, Segmented};
pub use standstills::Standstills;
pub use streams::Streams;
