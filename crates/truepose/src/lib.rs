#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

#[cfg(feature = "acceptance")]
pub use truepose_acceptance as acceptance;
#[cfg(feature = "compensate")]
pub use truepose_compensate as compensate;
#[cfg(feature = "controllers")]
pub use truepose_controllers as controllers;
#[cfg(feature = "discover")]
pub use truepose_discover as discover;
pub use truepose_errormodel as errormodel;
pub use truepose_identify as identify;
#[cfg(feature = "io")]
pub use truepose_io as io;
pub use truepose_kinematics as kinematics;
#[cfg(feature = "report")]
pub use truepose_report as report;
#[cfg(feature = "simulate")]
pub use truepose_simulate as simulate;
pub use truepose_solvers as solvers;
#[cfg(feature = "upkeep")]
pub use truepose_upkeep as upkeep;
#[cfg(feature = "workflow")]
pub use truepose_workflow as workflow;

/// What most programs need: `use truepose::prelude::*`.
pub mod prelude {
    #[cfg(feature = "compensate")]
    pub use crate::compensate::{Command, CommandRequest, Compensator, CompensatorOptions, Status, Target};
    #[cfg(feature = "discover")]
    pub use crate::discover::{DiscoverOptions, diagnose};
    pub use crate::errormodel::{Dataset, Effect, EffectRegistry, ErrorModel, FittedModel, Schema};
    pub use crate::identify::{IdentificationOptions, identify};
    #[cfg(feature = "io")]
    pub use crate::io::{read_fit, read_measurements, read_model, read_robot, write_fit};
    pub use crate::kinematics::{Chain, Conditions, Pose};
    pub use crate::solvers::{PivotedQr, Solver};
}
