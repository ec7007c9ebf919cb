#![doc = include_str!("../README.md")]

mod aim;
#[cfg(feature = "ndarray")]
mod arrays;
pub mod batch;
mod dataset;
mod derived;
pub mod descent;
mod effect;
pub mod effects;
mod emission;
mod equilibrium;
mod error;
mod fitted;
mod generalized;
mod jacobian;
pub mod lanes;
mod model;
mod noise;
pub mod observation;
mod real;
mod registry;
mod signal;
mod size;
mod term;
pub mod testkit;

pub use aim::{Aim, RobotPoint};
pub use dataset::{
    CARRIED, Channel, Dataset, DatasetBuilder, Dwell, DwellOptions, DwellTolerance, History, KIND, LANDMARK,
    MEETS, Measurement, Moving, POINT, RAY, Ray, Record, SENSOR, SESSION, Schema, Seen, Segmented,
    SessionRules, Standstills, Streams, TOOL, VALUE, Visits, approach_from_order, configurations, follow,
    history_channel, history_of, is_derived, is_of_observation, late_channel, own_channel, presliding,
    presliding_channel, presliding_of, step_channel, step_of, visits_from_rows,
};
pub use effect::{AnyEffect, Column, Effect, NonlinearParameter, Search, UNBOUNDED};
pub use emission::{Emission, Entry};
pub use equilibrium::Equilibrium;
pub use error::ModelError;
pub use fitted::{
    Beyond, Coverage, Domain, Fallback, FittedModel, Installed, Interval, Judged, LoadCorrection, Predictor,
    Sample, TargetKnown, own_target,
};
pub use generalized::{GeneralizedErrors, error_matrix, rotation_axes};
pub use jacobian::ErrorJacobian;
pub use model::{BoundModel, ErrorModel};
pub use noise::{NoiseModel, SMALLEST_SD};
pub use observation::{KnownDistance, Landmark, Surroundings};
pub use real::RealPosture;
pub use registry::EffectRegistry;
pub use signal::Signal;
pub use size::MOST_UNKNOWNS;
pub use term::Term;

/// What most programs need: `use truepose_errormodel::prelude::*`.
pub mod prelude {
    pub use crate::{
        AnyEffect, Column, Dataset, DatasetBuilder, Effect, EffectRegistry, Emission, ErrorModel,
        FittedModel, Measurement, ModelError, Predictor, Term,
    };
}
