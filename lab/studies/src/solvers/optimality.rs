//! The optimality conditions of the objective of each solver, from the rows alone.
//!
//! g_j = s_j a_jᵀ (A x − y), v = x / s; everything relative to ‖s_j a_j‖ ‖y‖
//!
//! | solver | zero at the optimum |
//! | --- | --- |
//! | least squares, robust with its final row weights | g |
//! | `bounded` | g inside; its part that points into the bounds at a bound |
//! | `ridge` | g + λ v |
//! | `lasso`, `elastic_net` | distance of −g − λ (1 − α) v from λ α ∂‖v‖₁ |
//! | `group_lasso` | distance of −g from λ √\|G\| ∂‖v_G‖, group by group |
//!
//! Shares nothing with the solvers' own checks.
//!
//! Every strategy that is compared.

use super::family::{Problem, Rows};
use crate::prelude::*;
use truepose_solvers::Solution;

/// Which conditions hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Conditions {
    /// Of least squares; with the row weights that a robust solver ends with.
    Squares,
    /// Of least squares within bounds.
    Bounded,
    /// Of a ridge.
    Ridge,
    /// Of a lasso or an elastic net of this mix.
    Absolute { mix: f64 },
    /// Of a group lasso.
    Groups,
    /// Of something else: a refit, a truncation.
    Unknown,
}

/// Largest violation, relative; none when the conditions are not known or there is no answer.
pub fn violation(conditions: Conditions, rows: &Rows, whole: &Problem, solution: &Solution) -> Option<f64> {
    let (Rows { a, y, .. }, Problem { scale, groups, bounds, .. }) = (rows, whole);
    let x = solution.answer()?;
    let root = |i: usize| solution.info.row_weights.as_ref().map_or(1.0, |w| w[i].sqrt());
    let weighted = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| root(i) * a[(i, j)] * scale[j]);
    let y = DVector::from_fn(y.len(), |i, _| root(i) * y[i]);
    let v = DVector::from_fn(x.len(), |j, _| x[j] / scale[j]);
    let g = weighted.tr_mul(&(&weighted * &v - &y));
    let size = |j: usize| (weighted.column(j).norm() * y.norm()).max(f64::MIN_POSITIVE);
    let lambda = solution.info.strength.unwrap_or(0.0);
    let worst = |f: &dyn Fn(usize) -> f64| (0..x.len()).map(|j| f(j).abs() / size(j)).fold(0.0, f64::max);
    match conditions {
        Conditions::Squares => Some(worst(&|j| g[j])),
        Conditions::Bounded => Some(worst(&|j| {
            let down = if x[j] > bounds.lower[j] { g[j].max(0.0) } else { 0.0 };
            let up = if x[j] < bounds.upper[j] { (-g[j]).max(0.0) } else { 0.0 };
            down.max(up)
        })),
        Conditions::Ridge => Some(worst(&|j| g[j] + lambda * v[j])),
        Conditions::Absolute { mix } => Some(worst(&|j| {
            let (pull, limit) = (g[j] + lambda * (1.0 - mix) * v[j], lambda * mix);
            if v[j] == 0.0 { (pull.abs() - limit).max(0.0) } else { pull + limit * v[j].signum() }
        })),
        Conditions::Groups => {
            let count = groups.iter().max().map_or(0, |g| g + 1);
            let each = (0..count).map(|group| {
                let members: Vec<usize> = (0..x.len()).filter(|&j| groups[j] == group).collect();
                let limit = lambda * (members.len() as f64).sqrt();
                let length =
                    |f: &dyn Fn(usize) -> f64| members.iter().map(|&j| f(j).powi(2)).sum::<f64>().sqrt();
                let norm = length(&|j| v[j]);
                let off = if norm == 0.0 {
                    (length(&|j| g[j]) - limit).max(0.0)
                } else {
                    length(&|j| g[j] + limit * v[j] / norm)
                };
                off / members.iter().map(|&j| size(j)).fold(f64::MIN_POSITIVE, f64::max)
            });
            Some(each.fold(0.0, f64::max))
        }
        Conditions::Unknown => None,
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solvers::family::Recipe;

    #[test]
    fn an_answer_that_is_moved_is_no_optimum() {
        let recipe = Recipe { condition: 1e3, noise: 0.1, outliers: 0.0, rows: 120, effects: 8, seed: 1 };
        let whole = Problem::new(&recipe);
        let rows = whole.rows(&(0..120).collect::<Vec<_>>());
        for (name, conditions) in [
            ("qr", Conditions::Squares),
            ("bounded(qr)", Conditions::Bounded),
            ("ridge(gcv)", Conditions::Ridge),
            ("lasso(ratio=0.1)", Conditions::Absolute { mix: 1.0 }),
            ("elastic_net(ratio=0.1)", Conditions::Absolute { mix: 0.5 }),
            ("group_lasso(ratio=0.1)", Conditions::Groups),
        ] {
            let solver = name.parse::<SolverSpec>().unwrap().build();
            let mut solution = solver.solve(&rows.problem(&whole, name.starts_with("bounded"))).unwrap();
            let at = |s: &Solution| violation(conditions, &rows, &whole, s).unwrap();
            assert!(at(&solution) < 1e-7, "{name}: {}", at(&solution));
            let j = solution.x.iamax();
            solution.x[j] *= 0.999;
            assert!(at(&solution) > 1e-7, "{name}: {}", at(&solution));
        }
    }
}
