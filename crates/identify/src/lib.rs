//! Identification.

mod error;
mod fit;
mod linearise;
mod noise;
pub mod reduction;
mod residuals;
mod variance;

pub use error::IdentifyError;
pub use fit::{Fit, FitOptions, NoiseSource, Warning, fit, refit, student_quantile};
pub use linearise::{Block, Lineariser, Rows, accumulate, collect, factorise};
pub use noise::NoiseModel;
pub use reduction::Reduction;
pub use residuals::{Residuals, Spread};
pub use variance::estimate_noise;
