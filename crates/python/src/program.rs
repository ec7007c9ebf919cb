//! The program inside the wheel.

use pyo3::prelude::*;
use std::ffi::OsString;
use truepose_cli::Extensions;

/// Runs the program with these arguments, of which the first is its name; the exit code. Once in a process.
#[pyfunction]
pub fn run(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| truepose_cli::run_with(Extensions::builtin(), arguments))
}
