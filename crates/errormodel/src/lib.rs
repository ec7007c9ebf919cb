#![doc = include_str!("../README.md")]

#[cfg(feature = "ndarray")]
mod arrays;
mod dataset;
mod effect;
pub mod effects;
mod emission;
mod error;
mod fitted;
mod generalized;
mod jacobian;
pub mod lanes;
mod limited;
mod model;
mod real;
mod registry;
mod rest;
pub mod testkit;

pub use dataset::{
    CARRIED, Channel, Dataset, Dwell, DwellTolerance, Schema, Seen, Visits, approach_from_order,
    configurations, is_derived, late_channel, visits_from_rows,
};
pub use effect::{AnyEffect, Column, Effect, Search, Shape, Signal, UNBOUNDED};
pub use emission::{Emission, Entry};
pub use error::ModelError;
pub use fitted::{
    Beyond, Coverage, Domain, FittedModel, Interval, Judged, LoadCorrection, Noise, Predictor, Sample,
    TargetKnown,
};
pub use generalized::{GeneralizedErrors, error_matrix, error_matrix_first_order, rotation_axes};
pub use jacobian::ErrorJacobian;
pub use limited::Limited;
pub use model::{BoundModel, ErrorModel};
pub use real::RealPosture;
pub use registry::EffectRegistry;
pub use rest::Rest;
