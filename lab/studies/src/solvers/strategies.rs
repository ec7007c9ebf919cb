//! Every strategy that is compared.

use super::optimality::Conditions;
use crate::prelude::*;

/// A solver, as it is typed, with what its answer has to satisfy.
pub struct Strategy {
    pub name: &'static str,
    pub solver: Box<dyn Solver>,
    pub conditions: Conditions,
    /// Whether its optimum is found by clarabel.
    pub conic: bool,
}

/// The first is what all others are compared with.
const ALL: [(&str, Conditions, bool); 16] = [
    ("qr", Conditions::Squares, false),
    ("svd", Conditions::Squares, false),
    ("svd(rcond=1e-6)", Conditions::Unknown, false),
    ("normal", Conditions::Squares, false),
    ("ridge(gcv)", Conditions::Ridge, false),
    ("ridge(lcurve)", Conditions::Ridge, false),
    ("ridge(cv)", Conditions::Ridge, false),
    ("ridge(map)", Conditions::Ridge, false),
    ("lasso", Conditions::Absolute { mix: 1.0 }, true),
    ("elastic_net", Conditions::Absolute { mix: 0.5 }, true),
    ("group_lasso", Conditions::Groups, true),
    ("group_lasso(refit)", Conditions::Unknown, true),
    ("bounded(qr)", Conditions::Bounded, true),
    ("huber(qr)", Conditions::Squares, false),
    ("tukey(qr)", Conditions::Squares, false),
    ("huber_exact", Conditions::Squares, true),
];

/// All of them.
pub fn strategies() -> Result<Vec<Strategy>, truepose_solvers::SolveError> {
    ALL.iter()
        .map(|&(name, conditions, conic)| {
            Ok(Strategy { name, solver: name.parse::<SolverSpec>()?.build(), conditions, conic })
        })
        .collect()
}
