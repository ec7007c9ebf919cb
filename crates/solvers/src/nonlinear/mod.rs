//! Nonlinear least squares: minimise ½ ‖r(x)‖².
//!
//! [`LevenbergMarquardt`] works by QR and needs no feature. [`profile`] takes out the unknowns in which a problem is linear, and searches
//! over the others alone. `TrustRegion` and `Lbfgs` (feature `argmin`) are argmin's, as independent solutions of the same problem.

mod levenberg_marquardt;
mod linearised;
mod problem;
mod profile;

#[cfg(feature = "argmin")]
mod bridge;
#[cfg(feature = "argmin")]
mod comparison;

pub use levenberg_marquardt::LevenbergMarquardt;
pub use problem::{FromClosures, NonlinearLeastSquares, NonlinearSolution, check_jacobian};
pub use profile::{Profiled, ProfiledSolution, Separable, profile};

#[cfg(feature = "argmin")]
pub use comparison::{Lbfgs, TrustRegion};
