#![doc = include_str!("../README.md")]

pub mod accumulator;
mod backends;
#[cfg(feature = "clarabel")]
pub mod conic;
mod dense;
mod error;
mod folds;
pub mod kernels;
mod minimum;
mod need;
pub mod nonlinear;
pub mod order;
mod problem;
mod rank;
pub mod ridge;
pub mod robust;
mod solver;
mod spec;
pub mod testkit;

pub use accumulator::{ColumnScale, Factor, Gram, NullSpace, Triangular};
pub use backends::{NormalEquations, PivotedQr, Svd};
#[cfg(feature = "clarabel")]
pub use conic::{Bounded, ElasticNet, ExactHuber, GroupLasso, Lasso, Strength};
pub use error::SolveError;
pub use folds::{Choice, GroupedFolds};
pub use minimum::{golden_section, minimum};
pub use nalgebra;
pub use need::Need;
pub use nonlinear::{LevenbergMarquardt, NonlinearLeastSquares, NonlinearSolution};
pub use problem::{Bounds, LeastSquares};
pub(crate) use rank::decide_rank;
pub use rank::{RankDecision, RankRule};
pub use ridge::{Ridge, RidgeStrength};
pub use robust::{Loss, Robust, Start, Trimming};
pub use solver::{Fallback, Solution, Solver, SolverInfo, Status};
pub use spec::SolverSpec;

/// What most programs need: `use truepose_solvers::prelude::*`.
pub mod prelude {
    pub use crate::{
        Bounds, LeastSquares, Need, PivotedQr, Robust, Solution, SolveError, Solver, SolverSpec, Status,
    };
}
