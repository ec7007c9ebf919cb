//! Order of a sweep: real campaigns go through the joints one after the other, which turns what changes with time into what
//! seems to change with a joint.

use super::Campaign;
use super::postures::{limits, variables};
use crate::SimulateError;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_kinematics::Chain;

/// Part of the range that a sweep keeps from either limit.
const EDGE: f64 = 0.05;

impl Campaign {
    /// The same poses in the order of a snake: joint `slow` goes through its range once, in `parts` parts, and within each
    /// part joint `fast` goes up, or down in every second part. Joints are counted from 0.
    ///
    /// # Errors
    /// [`SimulateError::Shape`] for a joint that the robot lacks.
    pub fn as_snake(mut self, slow: usize, fast: usize, parts: usize) -> Result<Self, SimulateError> {
        let have = self.visits.first().map_or(0, |visit| visit.joints.len());
        let need = slow.max(fast) + 1;
        if have < need {
            return Err(SimulateError::Shape { what: "movable joints", have, need });
        }
        self.visits.sort_by(|a, b| a.joints[slow].total_cmp(&b.joints[slow]));
        let length = self.visits.len().div_ceil(parts.max(1)).max(1);
        for (k, part) in self.visits.chunks_mut(length).enumerate() {
            part.sort_by(|a, b| a.joints[fast].total_cmp(&b.joints[fast]));
            if k % 2 == 1 {
                part.reverse();
            }
        }
        Ok(self)
    }

    /// Joint after joint goes evenly through its range while the others stay where they are drawn for that joint: `rounds`
    /// times through all joints, `count` poses in all.
    ///
    /// # Errors
    /// [`SimulateError::NoLimits`] for a slide without limits.
    pub fn joint_by_joint(
        chain: &Chain,
        count: usize,
        rounds: usize,
        seed: u64,
    ) -> Result<Self, SimulateError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let ends: Vec<(f64, f64)> = limits(chain)?
            .into_iter()
            .map(|(lower, upper)| (lower + EDGE * (upper - lower), upper - EDGE * (upper - lower)))
            .collect();
        let stretches = (rounds * ends.len()).clamp(1, count.max(1));
        let mut postures = Vec::with_capacity(count);
        for stretch in 0..stretches {
            let joint = stretch % ends.len();
            let length = count / stretches + usize::from(stretch < count % stretches);
            let still: Vec<f64> = ends.iter().map(|(l, h)| l + (h - l) * rng.random::<f64>()).collect();
            for k in 0..length {
                let part = (k as f64 + rng.random::<f64>()) / length as f64;
                let mut posture = still.clone();
                posture[joint] = ends[joint].0 + (ends[joint].1 - ends[joint].0) * part;
                postures.push(posture);
            }
        }
        Ok(Campaign::of(variables(chain, postures)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn a_snake_has_the_same_poses_in_another_order() {
        let chain = samples::heavy();
        let random = Campaign::random(&chain, 40, 3).expect("a campaign");
        let snake = random.clone().as_snake(0, 1, 5).expect("a snake");
        let sorted = |campaign: &Campaign| {
            let mut all: Vec<u64> = campaign.visits.iter().map(|v| v.joints[2].to_bits()).collect();
            all.sort_unstable();
            all
        };
        assert_eq!(sorted(&random), sorted(&snake));
        let joint = |k: usize, j: usize| snake.visits[k].joints[j];
        // The slow joint rises from part to part; the fast one rises in the first part and falls in the second.
        assert!((0..8).all(|k| (8..16).all(|l| joint(k, 0) < joint(l, 0))));
        assert!((1..8).all(|k| joint(k - 1, 1) < joint(k, 1)));
        assert!((9..16).all(|k| joint(k - 1, 1) > joint(k, 1)));
        assert!(random.as_snake(0, 9, 5).is_err());
    }

    #[test]
    fn one_joint_moves_at_a_time() {
        let chain = samples::heavy();
        let campaign = Campaign::joint_by_joint(&chain, 60, 2, 4).expect("a campaign");
        assert_eq!(campaign.visits.len(), 60);
        let moving = |k: usize| {
            let (a, b) = (&campaign.visits[k - 1].joints, &campaign.visits[k].joints);
            a.iter().zip(b).filter(|(a, b)| a.to_bits() != b.to_bits()).count()
        };
        // Twelve stretches of five poses: within a stretch one joint moves.
        assert!((1..60).filter(|k| k % 5 != 0).all(|k| moving(k) == 1));
        let limits = chain.joint(chain.movable()[0]).limits.expect("limits");
        assert!(campaign.visits.iter().all(|v| (limits.0..=limits.1).contains(&v.joints[0])));
    }
}
