//! Optimality of an answer, from the rows alone.
//!
//! g = Aᵀ W (A x − y), each component relative to ‖a_j‖ ‖y‖ in the weighted norm
//!
//! | demand | condition |
//! | --- | --- |
//! | stationary | g_j = 0 inside the bounds; g_j ≥ 0 at the lower, ≤ 0 at the upper |
//! | shrunken | xᵀ g ≤ 0 |
//!
//! W includes the row weights that a robust solver reports.

use crate::dense::norm;
use crate::{LeastSquares, Solution};
use nalgebra::DVector;

/// What the answer has to satisfy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Demand {
    Stationary,
    Shrunken,
}

/// Largest relative gradient that passes for a direct method.
const DIRECT: f64 = 1e-9;
/// The same for an iteration over weights, which ends at its own tolerance.
const ITERATED: f64 = 1e-5;

pub(super) fn stationary(
    problem: &LeastSquares<'_>,
    solution: &Solution,
    demand: Demand,
) -> Result<(), String> {
    let robust = solution.info.row_weights.as_ref();
    if let Some(weights) = robust.filter(|w| w.len() != problem.rows()) {
        return Err(format!("{} row weights for {} rows", weights.len(), problem.rows()));
    }
    let tolerance = if robust.is_some() { ITERATED } else { DIRECT };
    let factor = |i: usize| problem.root_weight(i) * robust.map_or(1.0, |w| w[i].sqrt());
    // Everything relative to y and to each column, so that no product leaves the range.
    let y_size = weighted_norm(problem.y, factor).max(f64::MIN_POSITIVE);
    let r = DVector::from_fn(problem.rows(), |i, _| {
        let fit: f64 = (0..problem.columns()).map(|j| problem.a[(i, j)] * solution.x[j]).sum();
        factor(i) * (fit - problem.y[i]) / y_size
    });
    let mut along = 0.0;
    for j in 0..problem.columns() {
        let column = DVector::from_fn(problem.rows(), |i, _| factor(i) * problem.a[(i, j)]);
        let size = norm(column.as_slice());
        if size < f64::MIN_POSITIVE {
            continue;
        }
        let g = (column / size).dot(&r);
        match demand {
            Demand::Shrunken => along += g * (solution.x[j] * size / y_size),
            Demand::Stationary => within(problem, solution, j, g, tolerance)?,
        }
    }
    if along > ITERATED {
        return Err(format!("a smaller answer would fit better: xᵀ g = {along:e}"));
    }
    Ok(())
}

fn within(
    problem: &LeastSquares<'_>,
    solution: &Solution,
    j: usize,
    g: f64,
    tolerance: f64,
) -> Result<(), String> {
    let x = solution.x[j];
    let (lower, upper) =
        problem.bounds.map_or((f64::NEG_INFINITY, f64::INFINITY), |b| (b.lower[j], b.upper[j]));
    if x < lower || x > upper {
        return Err(format!("unknown {j} = {x} leaves [{lower}, {upper}]"));
    }
    let free_down = x > lower && g > tolerance;
    let free_up = x < upper && g < -tolerance;
    if free_down || free_up {
        return Err(format!("gradient {g:e} along column {j}"));
    }
    Ok(())
}

fn weighted_norm(y: &DVector<f64>, factor: impl Fn(usize) -> f64) -> f64 {
    norm(&y.iter().enumerate().map(|(i, v)| v * factor(i)).collect::<Vec<_>>())
}
