//! What can be wrong with a file, and where.

use std::fmt;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A file that cannot be read, written or understood.
///
/// Lines and columns count from 1. In TOML, URDF and JSON a column is a character; in a CSV file it is a
/// column of the table, with its header and its number.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum IoError {
    /// The operating system refused to open or read the file.
    #[error("{}: cannot be read: {}", file.display(), reason(source))]
    Read {
        /// The file.
        file: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file could not be written; nothing was left behind.
    #[error("{}: cannot be written: {message}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// What went wrong, and what to do.
        message: String,
    },
    /// Something is wrong with the file as a whole.
    #[error("{}: {message}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What is wrong, and what to do.
        message: String,
    },
    /// Something is wrong at a place in a text.
    #[error("{}:{line}:{column}: {message}", file.display())]
    Text {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: u64,
        /// Character in the line, from 1.
        column: u64,
        /// What is wrong, and what to do.
        message: String,
    },
    /// Something is wrong with a line of a table.
    #[error("{}:{line}: {message}", file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: u64,
        /// What is wrong, and what to do.
        message: String,
    },
    /// Something is wrong with a cell of a table, or with the header of a column.
    #[error("{}:{line}: column `{name}` ({number}): {message}", file.display())]
    Cell {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: u64,
        /// The column's header.
        name: String,
        /// The column's number, from 1.
        number: usize,
        /// What is wrong, and what to do.
        message: String,
    },
    /// Several things are wrong, in the order of the file.
    #[error("{}", listed(errors, *more))]
    Several {
        /// The errors; at least one.
        errors: Vec<IoError>,
        /// How many others were seen.
        more: usize,
    },
}

/// Errors, one a line.
fn listed(errors: &[IoError], more: usize) -> String {
    let mut lines: Vec<String> = errors.iter().map(IoError::to_string).collect();
    if more > 0 {
        lines.push(format!("and {more} more"));
    }
    lines.join("\n")
}

impl IoError {
    /// Several errors as one; a single one stays what it is.
    pub(crate) fn several(mut errors: Vec<IoError>, more: usize) -> Self {
        match errors.len() {
            1 if more == 0 => errors.remove(0),
            _ => IoError::Several { errors, more },
        }
    }

    pub(crate) fn read(file: &Path, source: std::io::Error) -> Self {
        IoError::Read { file: file.into(), source }
    }

    pub(crate) fn file(file: &Path, message: impl Into<String>) -> Self {
        IoError::File { file: file.into(), message: message.into() }
    }

    pub(crate) fn line(file: &Path, line: u64, message: impl Into<String>) -> Self {
        IoError::Line { file: file.into(), line, message: message.into() }
    }

    /// The file that the error is about.
    pub fn path(&self) -> &Path {
        match self {
            IoError::Read { file, .. }
            | IoError::Write { file, .. }
            | IoError::File { file, .. }
            | IoError::Text { file, .. }
            | IoError::Line { file, .. }
            | IoError::Cell { file, .. } => file,
            IoError::Several { errors, .. } => errors.first().map_or(Path::new(""), IoError::path),
        }
    }

    /// The line that the error is about, from 1, where there is one.
    pub fn line_number(&self) -> Option<u64> {
        match self {
            IoError::Text { line, .. } | IoError::Line { line, .. } | IoError::Cell { line, .. } => {
                Some(*line)
            }
            IoError::Several { errors, .. } => errors.first().and_then(IoError::line_number),
            _ => None,
        }
    }
}

/// Something in a file that is suspicious but not wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1, where there is one.
    pub line: Option<u64>,
    /// Header and number (from 1) of the column, where there is one.
    pub column: Option<(String, usize)>,
    /// What is suspicious, and what to do.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, "{line}:")?;
        }
        if let Some((name, number)) = &self.column {
            write!(f, " column `{name}` ({number}):")?;
        }
        write!(f, " {}", self.message)
    }
}

/// The operating system's words for an error, without its number.
pub(crate) fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        std::io::ErrorKind::IsADirectory => "it is a folder".into(),
        _ => {
            let text = error.to_string();
            text.split(" (os error").next().unwrap_or(&text).to_lowercase()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_reported() {
        let cell = IoError::Cell {
            file: "data.csv".into(),
            line: 12,
            name: "theta[rad]".into(),
            number: 4,
            message: "`abc` is not a number".into(),
        };
        assert_eq!(cell.to_string(), "data.csv:12: column `theta[rad]` (4): `abc` is not a number");
        assert_eq!(cell.line_number(), Some(12));
        let warning = Warning {
            file: "d.csv".into(),
            line: Some(3),
            column: Some(("time[s]".into(), 2)),
            message: "m".into(),
        };
        assert_eq!(warning.to_string(), "d.csv:3: column `time[s]` (2): m");
    }

    #[test]
    fn an_error_is_small() {
        assert!(std::mem::size_of::<IoError>() <= 112);
    }
}
