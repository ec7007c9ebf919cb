#![doc = include_str!("../README.md")]

mod arm;
mod command;
mod compensator;
mod error;
mod options;
mod position_first;
mod real;
mod search;
mod starts;
mod step;
mod task;

pub use command::{Command, Extrapolation, MOST, Status, Target, Values};
pub use compensator::Compensator;
pub use error::CompensateError;
pub use options::{Approach, CompensatorOptions};
