//! truepose-io

mod error;
mod measurements;
mod nearest;
mod robot;
mod text;
mod toml_tree;
mod unit;
mod write_whole;

pub use error::{IoError, Warning};
pub use measurements::{ColumnInfo, CsvInfo, MeasurementsOptions, MeasurementsReader, read_measurements};
pub use robot::{RobotOptions, read_robot, robot_toml};
pub use unit::{Quantity, Unit};
pub use write_whole::{WholeFile, check_writable, write_whole};
