#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod accuracy;
mod arm;
mod command;
mod compensator;
mod error;
mod export;
mod exported_accuracy;
mod lanes;
mod options;
mod position_first;
mod real;
mod search;
mod starts;
mod step;
mod task;

pub use accuracy::{
    AccuracyMap, MapGrid, MapNode, MapOptions, PredictedError, accuracy_map, correction_helps,
    predicted_error, radius_95, radius_95_about,
};
pub use command::{Command, CommandRequest, Extrapolation, MOST, Status, Target, Values};
pub use compensator::Compensator;
pub use error::CompensateError;
pub use export::{
    AxisConvention, AxisLink, AxisRow, AxisTable, AxisTableOptions, Comparison, ErrorTable, ErrorTables,
    ExportOptions, Exported, Installation, JointOffset, JointOrigin, JointOrigins, Parameter, ParameterPart,
    ParameterTable, PartKind, RemainingError, RosStyle, StyledOrigins, axis_table, corrected_chain,
    error_tables, installation, installation_of, joint_origins, middle_conditions, parameter_table,
};
pub use exported_accuracy::Accuracy;
pub use options::{Approach, CompensatorOptions};

/// What most programs need: `use truepose_compensate::prelude::*`.
pub mod prelude {
    pub use crate::{
        Approach, Command, CommandRequest, CompensateError, Compensator, CompensatorOptions, Status, Target,
    };
}
