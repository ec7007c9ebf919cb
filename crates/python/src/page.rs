//! The folder of a report.

use crate::error::{input, of_io};
use pyo3::prelude::*;
use std::path::Path;
use truepose_io::{FileLock, Occupied, WholeFiles, check_writable, make_folder, sha256};
use truepose_report::{FileRecord, Report, RunRecord};

/// The program with its version, as reports and fits name it.
const PROGRAM: &str = concat!("truepose ", env!("CARGO_PKG_VERSION"));

/// The record of a run in Python, which has no arguments that `verify` could repeat.
pub fn record(result: &str, bytes: &[u8]) -> RunRecord {
    let record = FileRecord { file: result.into(), bytes: bytes.len() as u64, sha256: sha256(bytes) };
    RunRecord::new(PROGRAM, Vec::new(), Vec::new(), record)
}

/// Writes result, record, figures and page; each whole or not at all.
pub fn write(
    folder: &Path,
    result: &str,
    summary: &impl serde::Serialize,
    page: impl FnOnce(&RunRecord) -> PyResult<Report>,
) -> PyResult<()> {
    make_folder(folder).map_err(of_io)?;
    // Another program that writes there is waited for: no page is of two runs.
    let _locked = FileLock::of(folder, Occupied::Wait).map_err(of_io)?;
    for file in [result, "index.html", "summary.html", "run.json"] {
        check_writable(folder.join(file)).map_err(of_io)?;
    }
    let bytes = (serde_json::to_string_pretty(summary).map_err(input)? + "\n").into_bytes();
    let run = record(result, &bytes);
    let report = page(&run)?;
    let mut files = WholeFiles::default();
    let mut add = |name: &str, bytes: &[u8]| files.add(folder.join(name), bytes).map_err(of_io);
    add(result, &bytes)?;
    for (name, svg) in &report.figures {
        add(name, svg.as_bytes())?;
    }
    add("run.json", (serde_json::to_string_pretty(&run).map_err(input)? + "\n").as_bytes())?;
    if !report.summary.is_empty() {
        add("summary.html", report.summary.as_bytes())?;
    }
    add("index.html", report.html.as_bytes())?;
    files.finish().map(drop).map_err(of_io)
}
