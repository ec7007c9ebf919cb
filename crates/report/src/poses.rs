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
