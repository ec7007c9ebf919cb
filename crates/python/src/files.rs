//! Files that the package writes: whole or not at all, by the writer that all front ends have.

use crate::error::of_io;
use pyo3::prelude::*;
use std::path::PathBuf;
use truepose_io::write_whole;

/// Writes a text.
#[pyfunction]
pub fn write_text(path: PathBuf, text: &str) -> PyResult<()> {
    write_whole(path, text.as_bytes()).map(drop).map_err(of_io)
}
