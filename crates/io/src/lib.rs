#![doc = include_str!("../README.md")]

mod commanded;
mod corrections;
mod digest;
mod error;
mod export;
mod export_kinds;
mod fit;
mod frame_names;
mod history;
mod lock;
mod map;
mod measurements;
mod model;
mod nearest;
mod parameters;
mod plan;
mod poses;
mod predictions;
mod robot;
mod same_file;
mod table;
mod test_plan;
mod text;
mod toml_tree;
mod unfinished;
mod unit;
mod write_whole;

pub use corrections::{CorrectionRow, OffsetRow, corrections_file, offsets_files, read_bytes};
pub use digest::{file_digest, sha256};
pub use error::{IoError, Warning};
pub use export::{ExportUnits, write_measurements, write_observations};
pub use fit::{FIT_FORMAT, fit_json, parse_fit, read_fit, write_fit};
pub use history::{LookRecord, MonitorHistory};
pub use lock::{FileLock, Occupied};
pub use map::{MapRow, map_file, write_map};
pub use measurements::{
    ColumnInfo, ColumnMap, CsvInfo, Grouping, MeasurementsOptions, MeasurementsReader, MemoryColumn,
    MemoryTable, OrientationConvention, measurements_in_memory, read_measurements, sample_measurements,
};
pub use model::{model_from_text, read_model};
pub use parameters::{ParameterRow, parameters_file};
pub use plan::{PlannedRow, PlannedVisit, write_plan};
pub use poses::{
    CommandRow, CommandStatus, PoseForm, Poses, commands_file, poses_in_memory, read_poses, write_commands,
};
pub use predictions::{Prediction, PredictionsWriter, Repeated, write_predictions};
pub use robot::{
    Certificate, FrameParent, NamedFrame, RobotBeside, RobotDetails, RobotOptions, UrdfCorrection,
    corrected_urdf, read_details, read_kinematics, read_robot, robot_beside, robot_columns, robot_files,
    robot_from_text, robot_sessions, robot_surroundings, robot_toml, robot_urdf,
};
pub use same_file::same_file;
pub use test_plan::{TestPoseRow, write_test_plan};
pub use text::read_text;
pub use unfinished::{ScratchFolder, remove_empty_folders, stop_writing};
pub use unit::{Quantity, Unit};
pub use write_whole::{WholeFile, WholeFiles, check_writable, make_folder, write_whole};

/// What most programs need: `use truepose_io::prelude::*`.
pub mod prelude {
    pub use crate::{
        IoError, MeasurementsOptions, RobotOptions, Warning, read_fit, read_measurements, read_model,
        read_robot, write_fit,
    };
}
