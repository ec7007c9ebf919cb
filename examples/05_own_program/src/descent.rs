//! Least squares by cyclic coordinate descent: slow, and complete.

use truepose_solvers::nalgebra::DVector;
use truepose_solvers::{LeastSquares, Need, Solution, SolveError, Solver, Status};

/// Steps through all columns, at most.
const ROUNDS: usize = 1000;

/// The solver.
pub struct Descent;

impl Solver for Descent {
    fn name(&self) -> &str {
        "acme/descent"
    }

    fn supports(&self, need: Need) -> bool {
        need == Need::Weights
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        problem.admit(self)?;
        let mut x = DVector::zeros(problem.columns());
        let mut r = -problem.residual(&x);
        for _ in 0..ROUNDS {
            for j in 0..x.len() {
                let column =
                    DVector::from_fn(problem.rows(), |i, _| problem.root_weight(i) * problem.a[(i, j)]);
                let square = column.norm_squared();
                if square > 0.0 {
                    let step = column.dot(&r) / square;
                    x[j] += step;
                    r -= column * step;
                }
            }
        }
        Ok(Solution::new(problem, x, problem.rows().min(problem.columns()), Status::Converged))
    }
}
