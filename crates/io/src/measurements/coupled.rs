//! Columns of joints hold the controller's values; a data set holds the joints' variables.

use truepose_kinematics::Chain;

/// Turns the last row of these columns from the controller's values into the joints' variables.
pub(super) fn variables(chain: &Chain, columns: &mut [Vec<f64>]) {
    let mut values: Vec<f64> = columns.iter().filter_map(|column| column.last().copied()).collect();
    chain.joints_from_controller(&mut values);
    for (column, value) in columns.iter_mut().zip(values) {
        if let Some(last) = column.last_mut() {
            *last = value;
        }
    }
}

/// Turns the last row of these directions of approach into those of joints that follow others.
pub(super) fn sides(chain: &Chain, columns: &mut [Vec<f64>]) {
    for follower in chain.followers() {
        let side = columns[follower.driver].last().map_or(0.0, |side| side * follower.ratio.signum());
        if let Some(last) = columns[follower.joint].last_mut() {
            *last = side;
        }
    }
}

/// The joint, by its coordinate, in whose column a joint's value stands: its own, or that of the joint that it follows.
pub(super) fn column_of(chain: &Chain, k: usize) -> usize {
    chain.followers().iter().find(|follower| follower.joint == k).map_or(k, |follower| follower.driver)
}
