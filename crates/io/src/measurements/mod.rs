//! Measurements: tables in, columns in SI units out.
//!
//! ```text
//! Source ──► Header ──► RowReader ──► MeasurementsReader ──► blocks of rows
//!                                             └──► read_measurements: the whole file, its visits and approaches
//! ```

pub(crate) mod cells;
pub(crate) mod columns;
mod copies;
pub(crate) mod header;
mod info;
mod lines;
mod lost;
mod mixed;
#[cfg(feature = "parquet")]
mod parquet;
mod plausible;
mod reader;
mod row;
mod sample;
mod source;
mod suspicious;
mod together;
mod visits;
mod whole;

pub(crate) use header::Needs;
pub use info::{ColumnInfo, CsvInfo, Grouping};
pub use reader::{MeasurementsOptions, MeasurementsReader};
pub use sample::sample_measurements;
pub use whole::read_measurements;
pub(crate) use whole::read_table;
