//! Identification.

mod cross_validation;
mod error;
mod fit;
mod folds;
mod linearise;
mod noise;
mod placement;
pub mod reduction;
mod residuals;
mod variance;

pub use cross_validation::{CrossValidation, Method, cross_validate};
pub use error::IdentifyError;
pub use fit::{Fit, FitOptions, NoiseSource, Warning, fit, refit, student_quantile};
pub use folds::{Folds, Split, hold_out};
pub use linearise::{Block, Lineariser, Rows, accumulate, collect, factorise};
pub use noise::NoiseModel;
pub use placement::{Placement, Undetermined, place};
pub use reduction::Reduction;
pub use residuals::{Residuals, Spread};
pub use variance::estimate_noise;
