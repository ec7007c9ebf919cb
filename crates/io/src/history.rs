//! The looks at a robot since it was calibrated: one JSON file for a robot and its fit.

use crate::text::Text;
use crate::{IoError, write_whole};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Version of the format.
const FORMAT: &str = "truepose-monitor-1";

/// One look.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LookRecord {
    /// Name of the file of measurements.
    pub data: String,
    /// Its SHA-256.
    pub data_sha256: String,
    /// When it was measured, year-month-day.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Rows.
    pub rows: usize,
    /// Pose measurements.
    pub poses: usize,
    /// RMS of the residual, mm.
    pub rms_mm: f64,
    /// RMS of an unchanged robot, mm.
    pub expected_rms_mm: f64,
    /// p of the look.
    pub p_value: f64,
    /// Its level.
    pub level: f64,
    /// Whether p was below it.
    pub changed: bool,
    /// What had changed most likely.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub suspect: Option<String>,
}

/// All looks, in order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MonitorHistory {
    format: String,
    /// SHA-256 of the fit that they were held against.
    pub fit_sha256: String,
    /// The looks.
    pub looks: Vec<LookRecord>,
}

impl MonitorHistory {
    /// Without a look.
    pub fn new(fit_sha256: String) -> Self {
        MonitorHistory { format: FORMAT.into(), fit_sha256, looks: Vec::new() }
    }

    /// From its file.
    ///
    /// # Errors
    /// When it cannot be read, is no such file, or belongs to another fit.
    pub fn read(file: &Path, fit_sha256: &str) -> Result<Self, IoError> {
        let text = Text::read(file)?;
        let history: MonitorHistory = serde_json::from_str(&text.text).map_err(|error| {
            let words = error.to_string();
            IoError::Text {
                file: file.into(),
                line: error.line().max(1) as u64,
                column: error.column().max(1) as u64,
                message: format!(
                    "is not a history of `truepose monitor`: {}",
                    words.split(" at line ").next().unwrap_or(&words)
                ),
            }
        })?;
        let wrong = |message: String| IoError::file(file, message);
        if history.format != FORMAT {
            return Err(wrong(format!("is of format `{}`, not `{FORMAT}`", history.format)));
        }
        if history.fit_sha256 != fit_sha256 {
            return Err(wrong(
                "these looks were held against another fit; name another file for the history".into(),
            ));
        }
        Ok(history)
    }

    /// To its file, whole or not at all.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, file: &Path) -> Result<(), IoError> {
        let wrong = |error: serde_json::Error| IoError::file(file, error.to_string());
        let text = serde_json::to_string_pretty(self).map_err(wrong)? + "\n";
        write_whole(file, text.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_history_is_read_as_it_was_written_and_belongs_to_its_fit() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("looks.json");
        let mut history = MonitorHistory::new("a".into());
        history.looks.push(LookRecord {
            data: "monday.csv".into(),
            data_sha256: "b".into(),
            date: Some("2026-03-02".into()),
            rows: 36,
            poses: 12,
            rms_mm: 0.1,
            expected_rms_mm: 0.11,
            p_value: 0.4,
            level: 0.005,
            changed: false,
            suspect: None,
        });
        history.write(&file).unwrap();
        assert_eq!(MonitorHistory::read(&file, "a").unwrap(), history);
        let other = MonitorHistory::read(&file, "c").unwrap_err().to_string();
        assert!(other.contains("another fit"), "{other}");
        std::fs::write(&file, "{\"format\": 3}").unwrap();
        let damaged = MonitorHistory::read(&file, "a").unwrap_err().to_string();
        assert!(damaged.contains("looks.json:1:12: is not a history"), "{damaged}");
    }
}
