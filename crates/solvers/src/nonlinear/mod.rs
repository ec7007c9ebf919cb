//! Nonlinear least squares: minimise ½ ‖r(x)‖².
//!
//! [`LevenbergMarquardt`] is an argmin `Solver` of our own (argmin has none, and its Gauss-Newton inverts JᵀJ); argmin's
//! executor drives it. [`TrustRegion`] and [`Lbfgs`] are argmin's, for comparison. [`profile`] takes out the unknowns
//! in which a problem is linear, and searches over the others alone. The problem itself, [`NonlinearLeastSquares`], needs
//! no feature; the rest needs `argmin`.

mod problem;

#[cfg(feature = "argmin")]
mod bridge;
#[cfg(feature = "argmin")]
mod comparison;
#[cfg(feature = "argmin")]
mod levenberg_marquardt;
#[cfg(feature = "argmin")]
mod linearised;
#[cfg(feature = "argmin")]
mod profile;

pub use problem::{FromClosures, NonlinearLeastSquares, NonlinearSolution, check_jacobian};

#[cfg(feature = "argmin")]
pub use comparison::{Lbfgs, TrustRegion};
#[cfg(feature = "argmin")]
pub use levenberg_marquardt::{LevenbergMarquardt, LevenbergMarquardtState};
#[cfg(feature = "argmin")]
pub use profile::{Profiled, ProfiledSolution, Separable, profile};
