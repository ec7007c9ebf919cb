//! The direction in which each joint last moved, derived from the order of the visits.

use super::{Dataset, Visits};

/// Approach columns (−1, 0, +1 for each movable joint) from the order of the visits: by time where there is
/// one, else by row. A joint that did not move keeps the direction of its last move; before its first move it has 0.
pub fn approach_from_order(data: &Dataset) -> Vec<Vec<f64>> {
    let visits = Visits::of(data);
    let mut order: Vec<usize> = (0..visits.len()).collect();
    if data.schema.time {
        order.sort_by(|&a, &b| data.time[visits.rows[a][0]].total_cmp(&data.time[visits.rows[b][0]]));
    }
    data.joints
        .iter()
        .map(|column| {
            let mut approach = vec![0.0; column.len()];
            let mut direction = 0.0;
            for (k, &visit) in order.iter().enumerate() {
                let here = column[visits.rows[visit][0]];
                if k > 0 {
                    let step = here - column[visits.rows[order[k - 1]][0]];
                    if step.abs() > 1e-9 {
                        direction = step.signum();
                    }
                }
                for &row in &visits.rows[visit] {
                    approach[row] = direction;
                }
            }
            approach
        })
        .collect()
}
