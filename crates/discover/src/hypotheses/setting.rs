//! What hypotheses need to know about the robot and the data.

use crate::hypotheses::levels::Levels;
use std::sync::OnceLock;
use truepose_errormodel::{Dataset, is_of_observation};
use truepose_kinematics::{Chain, JointId, JointKind, PostureBuffer};

/// A robot with its data: what variants of a hypothesis are made for.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Setting<'a> {
    /// The robot.
    pub chain: &'a Chain,
    /// The data, with its derived channels.
    pub data: &'a Dataset,
    /// The range of the load of each movable joint, of this chain and data, computed when the first is asked for.
    loads: OnceLock<Vec<Option<[f64; 2]>>>,
}

impl<'a> Setting<'a> {
    /// Of a robot and its data.
    pub fn new(chain: &'a Chain, data: &'a Dataset) -> Self {
        Setting { chain, data, loads: OnceLock::new() }
    }

    /// The range of a joint that was visited, rad or m; none when it never moved.
    pub fn range(&self, joint: JointId) -> Option<[f64; 2]> {
        let column = &self.data.joints[self.chain.coordinate(joint)?];
        span(column)
    }

    /// The moves of a joint from each pose to the next, in the order in which they were measured, without their sign; rad or m, ascending.
    pub fn moves(&self, joint: JointId) -> Vec<f64> {
        let Some(column) = self.chain.coordinate(joint) else { return Vec::new() };
        let still = self.data.dwell.repeat_tolerance(column);
        let moves = self.data.moves(column).into_iter().map(f64::abs);
        let mut moves: Vec<f64> = moves.filter(|&step| step > still).collect();
        moves.sort_by(f64::total_cmp);
        moves
    }

    /// At how many distinct values a joint stood, and what they can tell of a function of it.
    pub fn levels(&self, joint: JointId) -> Levels {
        Levels::of(self.chain, self.data, joint)
    }

    /// The range of a channel, in its unit; none when it never changed, or says what was observed.
    pub fn channel_range(&self, channel: usize) -> Option<[f64; 2]> {
        let (kinds, columns) = (&self.data.schema.channels, &self.data.channels);
        if is_of_observation(&kinds[channel].name) {
            return None;
        }
        // A channel with the values of an earlier one has no hypotheses of its own.
        let same = |other: &usize| {
            let kind = |k: usize| (kinds[k].temperature, &kinds[k].unit);
            let equal = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
            kind(*other) == kind(channel) && columns[*other].iter().zip(&columns[channel]).all(equal)
        };
        if (0..channel).any(|other| same(&other)) {
            return None;
        }
        span(&columns[channel])
    }

    /// The range of the time, s, or of the numbers of the pose measurements where their order stands for it ([`Dataset::ordered`]): of what
    /// changes as the robot is measured. None without either, or when all rows have the same.
    pub fn record_range(&self) -> Option<[f64; 2]> {
        span(&self.data.time).filter(|_| self.data.schema.time)
    }

    /// The range of the time that a clock showed, s: of what depends on its rate. None without one, or when all rows have the same.
    pub fn time_range(&self) -> Option<[f64; 2]> {
        self.record_range().filter(|_| self.data.has_clock())
    }

    /// The range of the load about or along a joint, of some two hundred rows, N·m or N; none when nothing loads it.
    pub fn load_range(&self, joint: JointId) -> Option<[f64; 2]> {
        let coordinate = self.chain.coordinate(joint)?;
        self.loads.get_or_init(|| self.load_ranges())[coordinate]
    }

    fn load_ranges(&self) -> Vec<Option<[f64; 2]>> {
        let movable = self.chain.movable();
        let mut buffer = PostureBuffer::new(self.chain);
        let mut loads = vec![Vec::new(); movable.len()];
        let stride = (self.data.len() / 200).max(1);
        for row in (0..self.data.len()).step_by(stride) {
            let conditions = self.data.conditions(row);
            let posture = buffer.update(self.chain, &conditions);
            loads.iter_mut().zip(movable).for_each(|(loads, &joint)| loads.push(posture.joint_load(joint)));
        }
        loads.iter().map(|loads| span(loads)).collect()
    }

    /// The largest load about or along a joint, N·m or N.
    pub fn largest_load(&self, joint: JointId) -> f64 {
        self.load_range(joint).map_or(0.0, |[lower, upper]| lower.abs().max(upper.abs()))
    }

    /// Whether a joint is prismatic.
    pub fn slides(&self, joint: JointId) -> bool {
        self.chain.joint(joint).kind == JointKind::Prismatic
    }
}

fn span(column: &[f64]) -> Option<[f64; 2]> {
    let lower = column.iter().copied().fold(f64::INFINITY, f64::min);
    let upper = column.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (upper - lower > 1e-9 * (lower.abs() + upper.abs() + 1.0)).then_some([lower, upper])
}
