//! Unknowns of sensors from nothing: a linear start, then Gauss and Newton's method with the robot as it is.

use super::seam::{Observation, Reading, Seen};
use crate::descent::{Schedule, descend, relative_gain};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

const SCHEDULE: Schedule = Schedule {
    first: 1e-9,
    good: (0.1, 1e-12),
    bad: (100.0, 1e6),
    steps: 30,
    patience: (1, usize::MAX),
    flat: 1e-12,
    gain: relative_gain,
};

/// A sensor with its residuals and their derivatives.
type At = (Box<dyn Observation>, Vec<f64>, Vec<Vec<f64>>);

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
    let Some((right, rows)) = squares_of(from) else { return from.boxed() };
    let cost = sum(&right);
    let count = right.len();
    let propose = |(at, right, rows): &At, damping: f64| {
        let columns = rows.first().map_or(0, Vec::len);
        if columns == 0 || rows.len() < columns {
            return None;
        }
        let a = DMatrix::from_fn(rows.len(), columns, |i, k| rows[i][k]);
        let mut normal = a.tr_mul(&a);
        let largest = normal.diagonal().max();
        if largest <= 0.0 {
            return None;
        }
        for k in 0..columns {
            let own = normal[(k, k)];
            normal[(k, k)] = own * (1.0 + damping) + 1e-14 * largest;
        }
        let gradient = a.tr_mul(&DVector::from_column_slice(right));
        let next = at.moved(normal.cholesky()?.solve(&gradient).as_slice());
        Some(match squares_of(&*next).filter(|(r, _)| r.len() == count) {
            Some((r, j)) => {
                let cost = sum(&r);
                ((next, r, j), cost)
            }
            // It leaves out rows that the start sees.
            None => ((next, Vec::new(), Vec::new()), f64::INFINITY),
        })
    };
    descend(((from.boxed(), right, rows), cost), &SCHEDULE, propose, |next| next).0.0
}
