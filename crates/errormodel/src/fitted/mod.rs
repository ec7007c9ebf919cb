//! Fitted models: evaluation, the data of the fit, and whether a prediction lies within it.

mod both_sides;
mod coverage;
mod domain;
mod fallback;
mod installed;
mod landmarks;
mod load_correction;
mod model;
mod other_rows;
mod sample;
mod sessions;
mod spread;
mod without_order;

pub use coverage::{Beyond, Coverage, Judged, TargetKnown};
pub use domain::{Domain, Interval};
pub use installed::Installed;
pub use load_correction::LoadCorrection;
pub use model::{Fallback, FittedModel, Predictor};
pub use sample::Sample;
pub use sessions::own_target;
