//! Measurements: tables in, columns in SI units out.
//!
//! ```text
//! Source ──► Header ──► RowReader ──► MeasurementsReader ──► blocks of rows
//!                                             └──► read_measurements: the whole file, its visits and approaches
//! ```

mod beside_kind;
pub(crate) mod cells;
mod clock;
pub(crate) mod columns;
mod constants;
mod copies;
mod coupled;
mod dialect;
mod excluded;
pub(crate) mod header;
mod header_words;
mod info;
mod lines;
mod lost;
mod mapping;
mod memory;
mod missing;
mod mixed;
mod names;
mod open;
mod orientation;
#[cfg(feature = "parquet")]
mod parquet;
mod plausible;
mod problems;
mod proposal;
mod reader;
mod row;
mod sample;
mod sampled;
mod scalars;
#[cfg(feature = "xlsx")]
mod sheet;
mod source;
mod spelled_units;
mod suspicious;
mod taken;
mod texts;
mod together;
#[cfg(feature = "xlsx")]
mod unpacked;
mod visits;
mod whole;
mod workbook;

pub(crate) use header::Needs;
pub use info::{ColumnInfo, CsvInfo, Grouping};
pub use mapping::ColumnMap;
pub use memory::{MemoryColumn, MemoryTable};
pub use orientation::OrientationConvention;
pub use reader::{MeasurementsOptions, MeasurementsReader};
pub use sample::sample_measurements;
pub(crate) use whole::{From, read_table};
pub use whole::{measurements_in_memory, read_measurements};
