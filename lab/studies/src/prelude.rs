//! What most studies use: types of the crates, the journal, tables, statistics.

pub use crate::draw::Draw;
pub use crate::journal::{Journal, Kept, number, print_line};
pub use crate::results::finish;
pub use crate::simulated::*;
pub use crate::stats::*;
pub use crate::table::*;
pub use crate::words::{Half, Word};
pub use crate::{folder, parsed, print};
pub use clap::{Parser, ValueEnum};
pub use rand::{RngExt, SeedableRng};
pub use rand_chacha::ChaCha8Rng;
pub use rayon::prelude::*;
pub use serde::{Deserialize, Serialize};
pub use std::collections::BTreeMap;
pub use std::fmt::Write as _;
pub use std::path::Path;
pub use std::time::Instant;
pub use truepose_compensate::{Compensator, CompensatorOptions, Status};
pub use truepose_errormodel::effects::{Geometric, JointCompliance};
pub use truepose_errormodel::{AnyEffect, Dataset, EffectRegistry, ErrorModel, FittedModel, Visits};
pub use truepose_identify::{
    Fit, FitOptions, NoiseModel, NoiseSource, Prior, PriorStrength, Residuals, fit, refit,
};
pub use truepose_kinematics::nalgebra::{DMatrix, DVector, Matrix3, Vector3};
pub use truepose_kinematics::{
    Axis, Chain, Conditions, FrameId, Joint, JointId, JointKind, Link, Load, Payload, Placed, Placement,
    Pose, Target, TargetId, ToolId, samples,
};
pub use truepose_micro::clock::process;
pub use truepose_simulate::description::{InstrumentSize, PlantOptions, RepeatabilitySize, ShopDay};
pub use truepose_simulate::physics::changes::{Amount, Change, Mover};
pub use truepose_simulate::physics::transmission::TransmissionError;
pub use truepose_simulate::{
    Campaign, ChannelPlan, Disturbances, Flaws, Observation, Plant, Truth, Visit, flaws,
};
pub use truepose_solvers::{LeastSquares, PivotedQr, Solver, SolverSpec};

/// What goes wrong, whatever it is.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;
/// A result, or what went wrong.
pub type Outcome<T = ()> = Result<T, Failure>;
