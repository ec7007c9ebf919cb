//! The fitted model in forms that other controllers take: values here, files elsewhere.
//!
//! Each export says what it cannot carry, which error is left without it, and what it is worth beside the nominal robot; one that is
//! worse is refused.

mod axes_csv;
mod comparison;
mod geometry;
mod iso230;
mod left;
mod origins;
mod project;
mod reference;
mod ros;
mod table;
mod tables;

pub use axes_csv::AxisConvention;
pub use comparison::{Accuracy, Comparison};
pub use geometry::corrected_chain;
pub use left::{ErrorLeft, ExportOptions, Exported, middle_conditions};
pub use origins::{JointOrigin, JointOrigins, joint_origins};
pub use table::{AxisLink, AxisRow, AxisTable, AxisTableOptions, axis_table};
pub use tables::{ErrorTable, ErrorTables, error_tables};
