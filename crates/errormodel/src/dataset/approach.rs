//! The direction in which each joint last moved, derived from the order of the visits.

use super::table::Dataset;
use super::visits::Visits;

/// No joint moves by less than this, rad or m, whatever tolerance is asked for.
const LEAST: f64 = 1e-9;

/// Approach columns (−1, 0, +1 for each movable joint) from the order of the visits: by time where there is
/// one, else by row. A joint that did not move keeps the direction of its last move; before its first move it has 0.
///
/// What stays within the tolerance of [`Dataset::dwell`] is flicker and no move. It is counted from where the joint was after its last
/// move, so that a sweep of smaller steps is a move all the same.
pub fn approach_from_order(data: &Dataset) -> Vec<Vec<f64>> {
    let visits = Visits::of(data);
    let mut order: Vec<usize> = (0..visits.len()).collect();
    if data.schema.time {
        order.sort_by(|&a, &b| data.time[visits.rows[a][0]].total_cmp(&data.time[visits.rows[b][0]]));
    }
    data.joints
        .iter()
        .enumerate()
        .map(|(joint, column)| {
            let tolerance = data.dwell.tolerance(joint).max(LEAST);
            let mut approach = vec![0.0; column.len()];
            let (mut direction, mut last) = (0.0, None);
            for &visit in &order {
                let here = column[visits.rows[visit][0]];
                let step = here - *last.get_or_insert(here);
                if step.abs() > tolerance {
                    direction = step.signum();
                    last = Some(here);
                }
                for &row in &visits.rows[visit] {
                    approach[row] = direction;
                }
            }
            approach
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn approach(joint: &[f64]) -> Vec<f64> {
        let data =
            Dataset { joints: vec![joint.to_vec()], visit: (0..joint.len()).collect(), ..Dataset::default() };
        approach_from_order(&data).remove(0)
    }

    #[test]
    fn flicker_is_no_move_and_a_slow_sweep_is_one() {
        let flicker = 2e-6;
        assert_eq!(
            approach(&[0.0, 0.3, 0.3 - flicker, 0.3 + flicker, 0.3 - flicker]),
            [0.0, 1.0, 1.0, 1.0, 1.0]
        );
        assert_eq!(approach(&[0.3, 0.3 - flicker, 0.3]), [0.0; 3]);
        let sweep: Vec<f64> = (0..20).map(|k| 1.0 - 3e-6 * f64::from(k)).collect();
        let found = approach(&sweep);
        assert_eq!(found[..4], [0.0; 4]);
        assert_eq!(found[4..], [-1.0; 16]);
    }
}
