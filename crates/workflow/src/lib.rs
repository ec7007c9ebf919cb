#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod beyond;
mod campaign;
pub mod command;
mod discover;
mod error;
mod export;
mod folds;
mod identify;
mod interim;
pub mod joint_units;
mod library;
mod observe;
mod observer;
mod parameters;
mod place;
mod predict;
pub mod program;
mod provenance;
mod recorded;
mod sessions;
mod sister;
mod solver;
pub mod text;
mod verdict;

pub use campaign::{
    Campaign, CheckedRows, Fitting, InputFiles, Inputs, Mistakes, Nominal, Source, Undeclared, check_rows,
};
pub use discover::{DiscoverRequest, Discovered, Search};
pub use error::WorkflowError;
pub use export::{ExportFormat, ExportRequest, ExportedText, export};
pub use folds::{FoldsRequest, SplitKind, different, split, split_words};
pub use identify::{Identified, IdentifyRequest, about_rows, identify, record_streamed};
pub use interim::Interim;
pub use joint_units::Units;
pub use library::{Known, ROBOTS};
pub use observe::{PlanFrom, declared_landmarks, found_before, observing_target, plan_observed};
pub use observer::{Observer, Unobserved};
pub use parameters::{
    parameters, parameters_csv, parameters_of, record_details, recorded_frames, recorded_units,
};
pub use place::{GivenPlace, Place};
pub use predict::{Predicted, predict, predict_rows, targets_seen};
pub use provenance::PROGRAM;
pub use recorded::{record_columns, recorded_columns};
pub use sessions::{Part, in_session, one_installation};
pub use sister::{identify_sister, prior_remarks};
pub use solver::NamedSolver;
pub use verdict::{marks, record_transferred, usable};
