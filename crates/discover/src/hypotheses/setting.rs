//! What hypotheses need to know about the robot and the data.

use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, JointId, JointKind, PostureBuffer};

/// What the library needs to know about the data.
pub(crate) struct Setting<'a> {
    pub chain: &'a Chain,
    pub data: &'a Dataset,
}

impl Setting<'_> {
    /// The range of a joint that was visited; none when it never moved.
    pub fn range(&self, joint: JointId) -> Option<[f64; 2]> {
        let column = &self.data.joints[self.chain.coordinate(joint)?];
        span(column)
    }

    /// The range of a channel.
    pub fn channel_range(&self, channel: usize) -> Option<[f64; 2]> {
        span(&self.data.channels[channel])
    }

    /// The range of the load about or along a joint, of some two hundred rows, N·m or N; none when nothing loads it.
    pub fn load_range(&self, joint: JointId) -> Option<[f64; 2]> {
        let mut buffer = PostureBuffer::new(self.chain);
        let stride = (self.data.len() / 200).max(1);
        let load = |row| buffer.update(self.chain, &self.data.conditions(row)).joint_load(joint);
        let loads: Vec<f64> = (0..self.data.len()).step_by(stride).map(load).collect();
        span(&loads)
    }

    /// The largest load about or along a joint, N·m or N.
    pub fn largest_load(&self, joint: JointId) -> f64 {
        self.load_range(joint).map_or(0.0, |[lower, upper]| lower.abs().max(upper.abs()))
    }

    pub fn slides(&self, joint: JointId) -> bool {
        self.chain.joint(joint).kind == JointKind::Prismatic
    }
}

pub(crate) fn span(column: &[f64]) -> Option<[f64; 2]> {
    let lower = column.iter().copied().fold(f64::INFINITY, f64::min);
    let upper = column.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (upper - lower > 1e-9 * (lower.abs() + upper.abs() + 1.0)).then_some([lower, upper])
}
