//! The fitted model in forms that other controllers take: values here, files elsewhere.
//!
//! Each export says what it cannot carry, and which error is left without it.

mod axes_csv;
mod geometry;
mod iso230;
mod left;
mod origins;
mod ros;
mod table;
mod tables;

pub use axes_csv::AxisConvention;
pub use geometry::corrected_chain;
pub use left::{ErrorLeft, ExportOptions, Exported, middle_conditions};
pub use origins::{JointOrigin, JointOrigins, joint_origins};
pub use table::{AxisLink, AxisRow, AxisTable, AxisTableOptions, axis_table};
pub use tables::{ErrorTable, ErrorTables, error_tables};
