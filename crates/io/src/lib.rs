//! truepose-io

mod error;
mod nearest;
mod text;
mod unit;
mod write_whole;

pub use error::{IoError, Warning};
pub use unit::{Quantity, Unit};
pub use write_whole::{WholeFile, check_writable, write_whole};
