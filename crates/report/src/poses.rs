//! Errors by pose, as a specification limits them.

use truepose_errormodel::{Dataset, configurations};
use truepose_identify::Residuals;

/// The largest error of each configuration among these rows, m: the quantity that a specification limits.
pub fn largest_error_by_pose(data: &Dataset, rows: &[usize], errors: &Residuals) -> Vec<f64> {
    let configuration = configurations(data);
    let mut largest = vec![f64::NAN; configuration.iter().max().map_or(0, |last| last + 1)];
    for (k, &row) in rows.iter().enumerate() {
        if let Some(distance) = errors.distance(k) {
            let at = &mut largest[configuration[data.visit[row]]];
            *at = at.max(distance);
        }
    }
    largest.retain(|v| v.is_finite());
    largest
}

/// The same, each with its standard uncertainty as the instrument states it, in the direction of the error, m; NaN where it states none.
pub(crate) fn largest_error_and_uncertainty_by_pose(
    data: &Dataset,
    rows: &[usize],
    errors: &Residuals,
) -> Vec<(f64, f64)> {
    let configuration = configurations(data);
    let mut largest = vec![(f64::NAN, f64::NAN); configuration.iter().max().map_or(0, |last| last + 1)];
    for (k, &row) in rows.iter().enumerate() {
        let Some(distance) = errors.distance(k) else { continue };
        let at = &mut largest[configuration[data.visit[row]]];
        if at.0.is_nan() || distance > at.0 {
            let along = |axis: usize| errors.position[k][axis] / distance.max(f64::MIN_POSITIVE);
            let square: f64 = (0..3).map(|axis| (along(axis) * data.position_sd[row][axis]).powi(2)).sum();
            *at = (distance, square.sqrt());
        }
    }
    largest.retain(|pose| pose.0.is_finite());
    largest
}
