//! Values of joints that follow others, wherever values of joints are made up.

use super::table::Dataset;
use truepose_kinematics::Chain;

impl Dataset {
    /// Gives joints that follow others ([`truepose_kinematics::Mimic`]) their values in every row.
    pub fn follow(&mut self, chain: &Chain) {
        for follower in chain.followers() {
            let values = self.joints[follower.driver].iter();
            let values: Vec<f64> = values.map(|q| follower.ratio * q + follower.offset).collect();
            self.joints[follower.joint] = values;
        }
    }
}
