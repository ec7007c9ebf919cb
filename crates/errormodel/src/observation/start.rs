//! Unknowns of sensors from nothing: a linear start, then Gauss and Newton's method with the robot as it is.

use super::seam::{Observation, Reading, Seen};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Steps of Gauss and Newton's method.
const STEPS: usize = 30;

/// The mean of the targets' positions.
pub(super) fn centre(seen: &[Seen]) -> Vector3<f64> {
    seen.iter().map(|(at, _)| at.translation).sum::<Vector3<f64>>() / seen.len().max(1) as f64
}

/// The direction in which these points spread least, and their spread (standard deviations, m) along three directions, descending.
pub(super) fn thinnest(seen: &[Seen]) -> (Vector3<f64>, [f64; 3]) {
    let middle = centre(seen);
    let scatter: Matrix3<f64> = seen
        .iter()
        .map(|(at, _)| {
            let off = at.translation - middle;
            off * off.transpose()
        })
        .sum();
    let found = scatter.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| found.eigenvalues[b].total_cmp(&found.eigenvalues[a]));
    let spread = order.map(|k| (found.eigenvalues[k].max(0.0) / seen.len().max(1) as f64).sqrt());
    (found.eigenvectors.column(order[2]).into(), spread)
}

/// Least squares, by singular values; none where the equations do not determine the unknowns.
pub(super) fn solved(rows: &[Vec<f64>], right: &[f64]) -> Option<DVector<f64>> {
    let columns = rows.first()?.len();
    if rows.len() < columns {
        return None;
    }
    let mut a = DMatrix::from_fn(rows.len(), columns, |i, k| rows[i][k]);
    let norms: Vec<f64> = (0..columns).map(|k| a.column(k).norm()).collect();
    if norms.iter().any(|&norm| norm <= 0.0 || !norm.is_finite()) {
        return None;
    }
    norms.iter().enumerate().for_each(|(k, norm)| a.column_mut(k).scale_mut(1.0 / norm));
    let svd = a.svd(true, true);
    let largest = svd.singular_values.max();
    // What the nominal robot has wrong is a thousandth of its length: smaller singular values are made of that.
    if svd.singular_values.min() < 1e-4 * largest {
        return None;
    }
    let x = svd.solve(&DVector::from_column_slice(right), 0.0).ok()?;
    Some(DVector::from_fn(columns, |k, _| x[k] / norms[k]))
}

/// Fits the unknowns to the rows, the robot being what it is. Directions that the rows do not determine stay.
pub fn descended(from: &dyn Observation, seen: &[Seen]) -> Box<dyn Observation> {
    let mut best = from.boxed();
    let squares_of = |of: &dyn Observation| -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
        let (mut right, mut rows, mut reading) = (Vec::new(), Vec::new(), Reading::default());
        for (at, measured) in seen {
            if !of.read(at, &mut reading) {
                continue;
            }
            for (k, z) in measured.iter().enumerate().take(reading.value.len()) {
                right.push(z - reading.value[k]);
                rows.push(reading.by_own[k].clone());
            }
        }
        right.iter().all(|r| r.is_finite()).then_some((right, rows))
    };
    let sum = |right: &[f64]| right.iter().map(|r| r * r).sum::<f64>();
    let Some((mut right, mut rows)) = squares_of(&*best) else { return best };
    let mut damping = 1e-9;
    for _ in 0..STEPS {
        let columns = rows.first().map_or(0, Vec::len);
        if columns == 0 || rows.len() < columns {
            break;
        }
        let a = DMatrix::from_fn(rows.len(), columns, |i, k| rows[i][k]);
        let mut normal = a.tr_mul(&a);
        let largest = normal.diagonal().max();
        if largest <= 0.0 {
            break;
        }
        for k in 0..columns {
            let own = normal[(k, k)];
            normal[(k, k)] = own * (1.0 + damping) + 1e-14 * largest;
        }
        let gradient = a.tr_mul(&DVector::from_column_slice(&right));
        let Some(step) = normal.cholesky().map(|c| c.solve(&gradient)) else { break };
        let next = best.moved(step.as_slice());
        match squares_of(&*next) {
            Some((r, j)) if r.len() == right.len() && sum(&r) <= sum(&right) => {
                let still = sum(&right) - sum(&r) <= 1e-12 * sum(&right);
                (best, right, rows) = (next, r, j);
                damping = (damping * 0.1).max(1e-12);
                if still {
                    break;
                }
            }
            _ => damping *= 100.0,
        }
        if damping > 1e6 {
            break;
        }
    }
    best
}
