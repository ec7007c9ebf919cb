//! The `Solver` trait, its `Solution` and the termination `Status`.

use crate::{LeastSquares, Need, RankDecision, SolveError};
use nalgebra::DVector;

/// A strategy for linear least squares. A third-party solver implements these three methods, and passes
/// [`testkit::check_solver`](crate::testkit::check_solver).
///
/// ```
/// use truepose_solvers::{nalgebra::DVector, LeastSquares, Need, Solution, SolveError, Solver, Status};
///
/// /// Cyclic coordinate descent: slow, and complete.
/// struct CoordinateDescent;
///
/// impl Solver for CoordinateDescent {
///     fn name(&self) -> &str {
///         "coordinate_descent"
///     }
///     fn supports(&self, need: Need) -> bool {
///         need == Need::Weights
///     }
///     fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
///         problem.admit(self)?;
///         let mut x = DVector::zeros(problem.columns());
///         let mut r = -problem.residual(&x);
///         for _ in 0..1000 {
///             for j in 0..x.len() {
///                 let column = DVector::from_fn(problem.rows(), |i, _| problem.root_weight(i) * problem.a[(i, j)]);
///                 let square = column.norm_squared();
///                 if square > 0.0 {
///                     let step = column.dot(&r) / square;
///                     x[j] += step;
///                     r -= column * step;
///                 }
///             }
///         }
///         Ok(Solution::new(problem, x, problem.rows().min(problem.columns()), Status::Converged))
///     }
/// }
/// ```
pub trait Solver: Send + Sync {
    /// The name by which it is chosen and reported.
    fn name(&self) -> &str;
    /// Whether it supports this property of a problem; checked before any work.
    fn supports(&self, need: Need) -> bool;
    /// Solves. Not converging, or a deficient rank, is a [`Status`], not an error.
    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError>;
}

impl LeastSquares<'_> {
    /// [`validate`](Self::validate), and whether `solver` supports what this problem brings. Every backend calls
    /// it first.
    pub fn admit(&self, solver: &dyn Solver) -> Result<(), SolveError> {
        let refuse = |need| Err(SolveError::Unsupported { solver: solver.name().to_owned(), need });
        if self.is_bounded() && !solver.supports(Need::Bounds) {
            return refuse(Need::Bounds);
        }
        if self.weights.is_some() && !solver.supports(Need::Weights) {
            return refuse(Need::Weights);
        }
        self.validate()
    }
}

impl<S: Solver + ?Sized> Solver for Box<S> {
    fn name(&self) -> &str {
        (**self).name()
    }
    fn supports(&self, need: Need) -> bool {
        (**self).supports(need)
    }
    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        (**self).solve(problem)
    }
}

/// How a solution was ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// The optimum, to the solver's tolerance.
    Converged,
    /// The optimum of a problem whose unknowns are not all determined.
    RankDeficient {
        /// Number of directions that the data determine.
        rank: usize,
    },
    /// An optimum at reduced accuracy; the residual of the optimality conditions is in the info.
    AlmostConverged,
    /// The allowed iterations were used up; `x` is the last iterate.
    MaxIterations,
    /// The allowed time was used up.
    MaxTime,
    /// No further progress at this arithmetic, short of the tolerance.
    Stalled,
    /// No x satisfies the bounds.
    Infeasible,
    /// No x satisfies the bounds, at reduced accuracy.
    AlmostInfeasible,
    /// The objective has no minimum.
    Unbounded,
    /// The objective has no minimum, at reduced accuracy.
    AlmostUnbounded,
    /// Nothing was run.
    NotStarted,
    /// The arithmetic broke down; `x` is NaN.
    NumericalFailure,
    /// The caller cancelled the run.
    Interrupted,
}

impl Status {
    /// Whether `x` is an optimum (determined or not).
    pub fn is_success(self) -> bool {
        matches!(self, Status::Converged | Status::RankDeficient { .. } | Status::AlmostConverged)
    }
}

/// The answer of a solver.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The unknowns, p. Zero for columns that were dropped; NaN when there is no answer.
    pub x: DVector<f64>,
    /// Number of directions that the data determine.
    pub rank: usize,
    /// How it ended.
    pub status: Status,
    /// Diagnostics.
    pub info: SolverInfo,
}

/// Diagnostics of a solution. Fields that a solver does not compute stay at their default.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct SolverInfo {
    /// ‖W^{1/2} (A x − y)‖.
    pub residual_norm: f64,
    /// Singular values (or, from a pivoted QR, pivots) of the scaled matrix, largest first.
    pub singular_values: Option<Vec<f64>>,
    /// How the rank was decided.
    pub rank_decision: Option<RankDecision>,
    /// Iterations; 0 for a direct method.
    pub iterations: usize,
    /// Largest over smallest kept singular value of the scaled matrix.
    pub condition: Option<f64>,
    /// Columns that carry the answer, ascending; the others are zero by decision.
    pub kept: Option<Vec<usize>>,
    /// Strength of the penalty that was used.
    pub strength: Option<f64>,
    /// Effective number of parameters of a shrunken answer: trace of the hat matrix.
    pub effective_parameters: Option<f64>,
    /// Residual of the optimality conditions, relative, measured by us and not by the backend.
    pub optimality: Option<f64>,
    /// Factors by which a robust fit multiplied the weights of the rows; all 1 where it found no contamination.
    pub row_weights: Option<Vec<f64>>,
    /// Robust estimate of the standard deviation of a whitened row.
    pub noise: Option<f64>,
    /// Another method took over, and why.
    pub fallback: Option<Fallback>,
}

/// Another method took over.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Fallback {
    /// The Gram matrix was too ill conditioned for normal equations; QR answered.
    IllConditionedGram {
        /// Condition number of the scaled matrix.
        condition: f64,
        /// Highest that the guard lets pass.
        limit: f64,
    },
    /// The Gram matrix was not positive definite in floating point; QR answered.
    IndefiniteGram,
    /// A start from a trimmed fit was not possible; the plain fit was the start.
    PlainStart,
    /// The data gives no evidence of wrong visits: the answer is that of the inner solver, with every weight as it was.
    NoContamination,
}

impl Solution {
    /// An answer with its weighted residual norm filled in.
    pub fn new(problem: &LeastSquares<'_>, x: DVector<f64>, rank: usize, status: Status) -> Self {
        let residual_norm = crate::dense::norm(problem.residual(&x).as_slice());
        Self { x, rank, status, info: SolverInfo { residual_norm, ..SolverInfo::default() } }
    }

    /// The unknowns if the status is a success, else nothing.
    pub fn answer(&self) -> Option<&DVector<f64>> {
        self.status.is_success().then_some(&self.x)
    }
}

/// `Converged`, or `RankDeficient` when `rank` is below `columns`.
pub(crate) fn status_of_rank(rank: usize, columns: usize) -> Status {
    if rank < columns { Status::RankDeficient { rank } } else { Status::Converged }
}
