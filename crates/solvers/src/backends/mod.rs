//! The direct methods. Each is one file; all take the same problem and hand back the same solution.

mod normal;
mod qr;
mod svd;

pub use normal::NormalEquations;
pub use qr::PivotedQr;
pub use svd::Svd;

use crate::accumulator::{ColumnScale, Factor, Triangular};
use crate::{LeastSquares, Solution, SolveError};

impl Factor {
    /// The triangular factor of W^{1/2} [A | y] of a problem.
    pub fn of(problem: &LeastSquares<'_>) -> Result<Self, SolveError> {
        problem.validate()?;
        Ok(Self::of_valid(problem))
    }

    pub(crate) fn of_valid(problem: &LeastSquares<'_>) -> Self {
        let mut t = Triangular::new(problem.columns(), 1);
        t.take_problem(problem);
        t.finish()
    }
}

impl<'a> LeastSquares<'a> {
    /// How the columns of this problem are scaled before anything is decided.
    pub fn column_scale(&self) -> ColumnScale<'a> {
        self.scale.map_or(ColumnScale::Norms, ColumnScale::Given)
    }

    /// The residual norm of `solution` taken from the rows themselves.
    pub(crate) fn with_true_residual(&self, mut solution: Solution) -> Solution {
        solution.info.residual_norm = crate::dense::norm(self.residual(&solution.x).as_slice());
        solution
    }
}
