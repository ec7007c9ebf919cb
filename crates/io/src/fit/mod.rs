//! Fit files: a fitted model with its robot, as versioned JSON.
//!
//! A file needs nothing else to be evaluated. Numbers have the digits that read back to the same bits, and keys
//! their fixed order, so that equal models make equal bytes.

mod check;
mod fallback_v1;
mod parts_v1;
mod read;
mod robot_v1;
mod sample_v1;
mod schema_v1;
mod sessions_v1;
mod write;

pub use read::{fit_from_text, read_fit};
pub use write::{fit_json, write_fit};

/// The format that this version writes, and the newest that it reads.
pub const FIT_FORMAT: u64 = 1;

/// The program that writes the file.
pub(crate) const PROGRAM: &str = concat!("truepose ", env!("CARGO_PKG_VERSION"));
