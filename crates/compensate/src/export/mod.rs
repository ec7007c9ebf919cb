//! The fitted model in forms that other controllers take: values here, files elsewhere.
//!
//! Each export states what it cannot carry, the remaining error, and its accuracy beside the nominal robot; one that is
//! worse is refused.

mod axes_csv;
mod comparison;
mod geometry;
mod iso230;
mod origins;
mod project;
mod reference;
mod remaining;
mod ros;
mod table;
mod tables;

pub use axes_csv::AxisConvention;
pub use comparison::{Accuracy, Comparison};
pub use geometry::corrected_chain;
pub use origins::{JointOrigin, JointOrigins, joint_origins};
pub use remaining::{ExportOptions, Exported, RemainingError, middle_conditions};
pub use table::{AxisLink, AxisRow, AxisTable, AxisTableOptions, axis_table};
pub use tables::{ErrorTable, ErrorTables, error_tables};
