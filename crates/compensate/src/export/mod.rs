//! The fitted model in forms that other controllers take: values here, files elsewhere.
//!
//! Each export states what it cannot carry, the remaining error, and its accuracy beside the nominal robot; one that is
//! worse is refused.

mod axes_csv;
mod cell;
mod comparison;
mod error_tables;
mod geometry;
mod installation;
mod iso230;
mod link_frames;
mod options;
mod origins;
mod parameters;
mod project;
mod reference;
mod remaining;
mod ros;
mod styles;
mod table;
mod tables;

pub use axes_csv::AxisConvention;
pub use comparison::Comparison;
pub use error_tables::{ErrorTable, ErrorTables};
pub use geometry::corrected_chain;
pub use installation::{Installation, installation, installation_of};
pub use options::{ExportOptions, middle_conditions};
pub use origins::{JointOrigin, JointOrigins, joint_origins};
pub use parameters::{JointOffset, Parameter, ParameterPart, ParameterTable, PartKind, parameter_table};
pub use remaining::{Exported, RemainingError};
pub use styles::{RosStyle, StyledOrigins};
pub use table::{AxisLink, AxisRow, AxisTable, AxisTableOptions, axis_table};
pub use tables::error_tables;
