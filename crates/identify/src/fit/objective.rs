//! What a solver minimises.

use truepose_solvers::{Need, Solver};

/// Whether what a solver minimises is known: squares and the prior, nothing else.
pub(crate) fn guarded(solver: &dyn Solver) -> bool {
    solver.supports(Need::Unpenalised) && !solver.supports(Need::Outliers)
}
