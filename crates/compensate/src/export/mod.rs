//! The fitted model in forms that other controllers take: values here, files elsewhere.
//!
//! Each export says what it cannot carry, and which error is left without it.

mod geometry;
mod left;
mod table;
mod tables;

pub use geometry::corrected_chain;
pub use left::{ErrorLeft, ExportOptions, Exported};
pub use table::{AxisLink, AxisRow, AxisTable, AxisTableOptions, axis_table};
pub use tables::{ErrorTable, ErrorTables, error_tables};
