//! Errors by pose.

use truepose_errormodel::{Dataset, configurations};
use truepose_identify::Residuals;

/// The largest error of each configuration among these rows, m: what a specification is held against.
pub fn worst_of_poses(data: &Dataset, rows: &[usize], errors: &Residuals) -> Vec<f64> {
    let configuration = configurations(data);
    let mut worst = vec![f64::NAN; configuration.iter().max().map_or(0, |last| last + 1)];
    for (k, &row) in rows.iter().enumerate() {
        if let Some(distance) = errors.distance(k) {
            let at = &mut worst[configuration[data.visit[row]]];
            *at = at.max(distance);
        }
    }
    worst.retain(|v| v.is_finite());
    worst
}
