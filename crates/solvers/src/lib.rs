#![doc = include_str!("../README.md")]

pub mod accumulator;
mod backends;
mod dense;
mod error;
mod problem;
mod rank;
mod solver;
pub mod testkit;

pub use accumulator::{ColumnScale, Factor, Gram, NullSpace, Triangular};
pub use backends::{NormalEquations, PivotedQr, Svd};
pub use error::SolveError;
pub use nalgebra;
pub use problem::{Bounds, LeastSquares};
pub use rank::{RankDecision, RankRule, decide_rank};
pub use solver::{Fallback, Need, Solution, Solver, SolverInfo, Status};
