//! Which movable joints have a column in tables: all but those that follow others.

use truepose_kinematics::Chain;

/// Coordinates of the joints that the controller has values for, in order.
pub(crate) fn commanded(chain: &Chain) -> Vec<usize> {
    (0..chain.movable().len()).filter(|&k| chain.is_commanded(k)).collect()
}

/// Names of these joints.
pub(crate) fn commanded_names(chain: &Chain) -> Vec<&str> {
    commanded(chain).into_iter().map(|k| chain.joint(chain.movable()[k]).name.as_str()).collect()
}
