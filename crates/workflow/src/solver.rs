//! A solver with its name.

use truepose_solvers::Solver;

/// A solver, and the text that chooses it.
pub struct NamedSolver {
    /// As in results.
    pub name: String,
    /// The solver.
    pub solver: Box<dyn Solver>,
}
