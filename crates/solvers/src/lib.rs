//! x
pub mod accumulator;
mod dense;
mod error;
mod problem;
mod rank;
mod solver;

pub use error::SolveError;
pub use nalgebra;
pub use problem::{Bounds, LeastSquares};
pub use rank::{decide_rank, RankDecision, RankRule};
pub use solver::{Fallback, Need, Solution, Solver, SolverInfo, Status};
