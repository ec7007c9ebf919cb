//! Fitted models: evaluation, the data of the fit, and whether a prediction lies within it.

mod coverage;
mod domain;
mod fallback;
mod landmarks;
mod model;
mod sample;
mod sessions;
mod spread;

pub use coverage::{Beyond, Coverage, Judged, TargetKnown};
pub use domain::{Domain, Interval};
pub use model::{Fallback, FittedModel, LoadCorrection, Predictor};
pub use sample::Sample;
pub use sessions::{Installed, own_target};
