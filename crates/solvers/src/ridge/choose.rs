//! Three ways to a strength: generalized cross-validation, the corner of the L-curve, and groups left out.

use super::RidgePath;
use crate::folds::GroupedFolds;
use crate::minimum::golden_section;
use crate::{ColumnScale, LeastSquares, SolveError};

const GRID: usize = 80;
/// Golden sections: 0.618⁶⁰ = 3e-13 of the grid's step.
const STEPS: usize = 60;

/// λ of least generalized cross-validation score: grid, then golden section between its neighbours.
pub(super) fn gcv(path: &RidgePath) -> f64 {
    let grid = path.strengths(GRID);
    let mut best = 0;
    for (k, lambda) in grid.iter().enumerate() {
        if path.gcv(*lambda) < path.gcv(grid[best]) {
            best = k;
        }
    }
    let (high, low) = (grid[best.saturating_sub(1)], grid[(best + 1).min(grid.len() - 1)]);
    if low <= 0.0 {
        grid[best]
    } else {
        golden_section(low.ln(), high.ln(), STEPS, |l| path.gcv(l.exp())).exp()
    }
}

/// λ where the curve (ln ‖r‖, ln ‖S⁻¹ x‖) bends most.
pub(super) fn corner(path: &RidgePath) -> f64 {
    let grid = path.strengths(2 * GRID);
    let floor = f64::MIN_POSITIVE;
    let points: Vec<(f64, f64)> = grid
        .iter()
        .map(|&l| (path.residual_norm(l).max(floor).ln(), path.solution_norm(l).max(floor).ln()))
        .collect();
    let mut best = (0.0, grid[grid.len() - 1]);
    for k in 1..points.len().saturating_sub(1) {
        let (a, b, c) = (points[k - 1], points[k], points[k + 1]);
        let (first, second) =
            (((c.0 - a.0) / 2.0, (c.1 - a.1) / 2.0), (c.0 - 2.0 * b.0 + a.0, c.1 - 2.0 * b.1 + a.1));
        let speed = (first.0.powi(2) + first.1.powi(2)).powf(1.5);
        // The grid falls, so residual falls and size grows: the corner turns clockwise.
        let bend = first.1 * second.0 - first.0 * second.1;
        if speed > 0.0 && bend / speed > best.0 {
            best = (bend / speed, grid[k]);
        }
    }
    best.1
}

/// λ of least error on groups left out. The columns are scaled alike in all folds.
pub(super) fn grouped(
    problem: &LeastSquares<'_>,
    path: &RidgePath,
    folds: GroupedFolds,
) -> Result<f64, SolveError> {
    let grid = path.strengths(GRID);
    let mut errors = vec![Vec::new(); grid.len()];
    for split in folds.split(problem)? {
        let part = RidgePath::new(&split.train, ColumnScale::Given(&path.scale))?;
        // Fewer rows, fewer squares: the penalty shrinks with them.
        let share = split.train.rows as f64 / problem.rows() as f64;
        for (lambda, errors) in grid.iter().zip(&mut errors) {
            errors.push(split.error(&part.x(share * lambda)));
        }
    }
    Ok(grid[folds.choose(&errors)])
}
