//! A derived channel: the last move of a joint, from the order of poses.
//!
//! ```text
//! step_k = q_k − q_(k−1)        rad or m; 0 at the first pose of the record
//! ```
//!
//! The channel is called by the joint's number in the robot (from 1, fixed joints count): `step~3`. A log that lags, or a joint that has not
//! settled, is displaced in proportion to it.

use super::table::Dataset;
use truepose_kinematics::JointId;

/// What stands in front of the joint's number.
const STEP: &str = "step~";

/// The name of the channel of a joint's last move.
pub fn step_channel(joint: JointId) -> String {
    format!("{STEP}{}", joint.0)
}

/// The joint of a channel of this name; none of other channels.
pub fn step_of(channel: &str) -> Option<JointId> {
    let number = channel.strip_prefix(STEP)?.parse().ok().filter(|&number| number > 0)?;
    Some(JointId(number))
}

impl Dataset {
    /// The last move of a movable joint (by its column) at every row, rad or m.
    pub fn last_step(&self, joint: usize) -> Vec<f64> {
        self.whole().last_step(joint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_the_rows_remembers_the_pose_before() {
        let n = 5;
        let data = Dataset {
            joints: vec![vec![0.1, 0.1, 0.4, 0.2, 0.25]],
            approach: vec![vec![0.0; n]],
            // Two targets of the first pose.
            visit: vec![0, 0, 1, 2, 3],
            time: vec![0.0; n],
            position: vec![[0.0; 3]; n],
            orientation: vec![None; n],
            position_sd: vec![[f64::NAN; 3]; n],
            orientation_sd: vec![[f64::NAN; 3]; n],
            target: vec![None; n],
            load: vec![truepose_kinematics::Load::None; n],
            ..Dataset::default()
        };
        let expected = [0.0, 0.0, 0.3, -0.2, 0.05];
        for (found, expected) in data.last_step(0).iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
        let whole = data.last_step(0);
        assert_eq!(data.select(&[4, 2]).last_step(0), [whole[4], whole[2]]);
    }

    #[test]
    fn names_read_back() {
        assert_eq!(step_of(&step_channel(JointId(3))), Some(JointId(3)));
        for other in ["step_3", "step~", "step~0", "step~a", "z_3~w=0.05"] {
            assert_eq!(step_of(other), None, "{other}");
        }
    }
}
