//! The fit of a model whose nonlinear parameters are known.

mod believed;
mod constraints;
mod fixed;
mod objective;
mod options;
mod result;
mod rounds;
mod warnings;

pub(crate) use fixed::fit_fixed;
pub use fixed::{fit_again, refit};
pub(crate) use objective::guarded;
pub use options::{FitOptions, NoiseSource, NonlinearSearch};
pub use result::{Fit, FittedNonlinear};
pub(crate) use rounds::from_factor;
pub use warnings::{Refusal, Warning};
