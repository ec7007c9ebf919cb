//! The record that makes a run reproducible: `run.json`.

use serde::{Deserialize, Serialize};

/// A run of the program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    /// Always `truepose-run`.
    pub format: String,
    /// Version of this file's form.
    pub version: u32,
    /// Program and version.
    pub program: String,
    /// What was typed after the program's name.
    pub arguments: Vec<String>,
    /// Files that were read.
    pub inputs: Vec<FileRecord>,
    /// The file with the run's result, beside this one.
    pub result: FileRecord,
    /// Head of the report: names and texts of `[certificate]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certificate: Option<Vec<(String, String)>>,
}

/// A file as it was.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileRecord {
    /// Its name, as it was typed.
    pub file: String,
    /// Its length.
    pub bytes: u64,
    /// Its SHA-256 in hexadecimal digits.
    pub sha256: String,
}

impl RunRecord {
    /// Word of the form.
    pub const FORMAT: &'static str = "truepose-run";

    /// Of a run.
    pub fn new(program: &str, arguments: Vec<String>, inputs: Vec<FileRecord>, result: FileRecord) -> Self {
        let (format, program) = (Self::FORMAT.into(), program.into());
        RunRecord { format, version: 1, program, arguments, inputs, result, certificate: None }
    }
}
