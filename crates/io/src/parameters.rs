//! The parameters of a fitted robot as a CSV file.

use crate::table::TableWriter;
use crate::{IoError, WholeFile};
use std::path::Path;

/// One parameter, in the unit of its row. NaN makes an empty cell.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterRow {
    /// Base, joint, tool or target.
    pub part: String,
    /// Its name, `theta`, `x`, …; `zero_offset` for the correction of a joint's zero.
    pub parameter: String,
    /// Unit of the numbers.
    pub unit: String,
    /// As described.
    pub nominal: f64,
    /// Calibrated minus nominal.
    pub delta: f64,
    /// As fitted.
    pub calibrated: f64,
    /// Half width of the 95 % interval.
    pub interval_95: f64,
    /// Why it was not estimated; empty where it was.
    pub remark: String,
}

/// The file of these rows, under no name yet.
///
/// # Errors
/// When it cannot be written.
pub fn parameters_file(path: impl AsRef<Path>, rows: &[ParameterRow]) -> Result<WholeFile, IoError> {
    let header = ["part", "parameter", "unit", "nominal", "delta", "calibrated", "plus_minus_95", "remark"];
    let mut table = TableWriter::create(path.as_ref(), &header.map(String::from))?;
    for row in rows {
        for text in [&row.part, &row.parameter, &row.unit] {
            table.text(text);
        }
        for number in [row.nominal, row.delta, row.calibrated, row.interval_95] {
            table.number(number);
        }
        table.text(&row.remark);
        table.end_row()?;
    }
    Ok(table.into_file())
}
