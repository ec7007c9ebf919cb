//! An identified arm in another installation, and whether it has changed since: one summary each, shown as text or as JSON.

mod fleet;
mod history;
mod monitor;
mod transfer;

pub use fleet::{FleetSummary, SisterSummary};
pub use history::{LookView, history_page, monitor_report};
pub use monitor::MonitorSummary;
pub use transfer::TransferSummary;

use crate::{count, value_with_interval};

/// `0.21 mrad`, from a value in its own unit.
pub(crate) fn quantity(value: f64, unit: &str) -> String {
    let (_, half, unit) = value_with_interval(value, value.abs(), unit);
    format!("{half} {unit}")
}

/// `row 7 (line 8)`: numbered from one, with the line of the file where it is known.
pub(crate) fn row_words(row: usize, lines: &[u64]) -> String {
    match lines.get(row) {
        Some(line) => format!("row {} (line {line})", row + 1),
        None => format!("row {}", row + 1),
    }
}

/// `12 rows, 4 pose measurements`.
pub(crate) fn size(rows: usize, poses: usize) -> String {
    format!("{}, {}", count(rows, "row"), count(poses, "pose measurement"))
}
