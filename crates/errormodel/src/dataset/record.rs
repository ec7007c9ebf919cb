//! The order of poses of a whole record, which its parts remember.
//!
//! What a joint does depends on the way by which it came. A part of the rows (training, a fold, a sample) does not contain that way, so that
//! every part of a data set keeps the joint values of all poses of the whole, by time where there is one, else by row.

use super::loads::NominalLoads;
use std::sync::Arc;
use truepose_kinematics::{Chain, JointId, Load};

/// The poses of a whole record in their order, and which of them the rows of a data set are.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    poses: Arc<Poses>,
    /// The pose of each row.
    pose: Vec<usize>,
}

#[derive(Debug, PartialEq)]
struct Poses {
    /// One column for each movable joint, rad or m.
    joints: Vec<Vec<f64>>,
    /// One column for each movable joint: the direction in which it last moved, −1, 0, 1.
    approach: Vec<Vec<f64>>,
    /// What a joint moves by in repeats of one configuration, rad or m.
    still: Vec<f64>,
    /// When each pose was measured, s; zero without a time.
    time: Vec<f64>,
    /// The load of each pose.
    load: Vec<Load>,
    /// Loads of all joints, once one is asked for.
    nominal: NominalLoads,
}

impl Record {
    /// Of the joints and directions of approach by pose, of what a joint moves by in repeats, of times and loads by pose, and of the pose of
    /// each row.
    pub(super) fn new(
        [joints, approach]: [Vec<Vec<f64>>; 2],
        still: Vec<f64>,
        (time, load): (Vec<f64>, Vec<Load>),
        pose: Vec<usize>,
    ) -> Self {
        let nominal = NominalLoads::default();
        Record { poses: Arc::new(Poses { joints, approach, still, time, load, nominal }), pose }
    }

    /// Of a part of its rows.
    pub(super) fn select(&self, rows: &[usize]) -> Self {
        Record { poses: Arc::clone(&self.poses), pose: rows.iter().map(|&row| self.pose[row]).collect() }
    }

    /// The moves of a joint, the way from each pose to the next, rad or m.
    pub(super) fn moves(&self, joint: usize) -> Vec<f64> {
        self.poses.joints.get(joint).map_or_else(Vec::new, |q| q.windows(2).map(|q| q[1] - q[0]).collect())
    }

    /// The last move of a joint at every row, rad or m.
    pub(super) fn last_step(&self, joint: usize) -> Vec<f64> {
        let steps = self.moves(joint);
        let before = |pose: usize| pose.checked_sub(1).and_then(|k| steps.get(k)).copied();
        self.pose.iter().map(|&pose| before(pose).unwrap_or(0.0)).collect()
    }

    /// A state of a joint at every row: zero at the first pose, then what `next` makes of it and of the move to the next pose. Where another
    /// direction of approach is stated than that of the move, the joint came from farther on that side: the move is infinite.
    pub(super) fn follow(&self, joint: usize, next: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let mut state = 0.0;
        let mut states = vec![0.0];
        let approach = self.poses.approach.get(joint);
        for (k, step) in self.moves(joint).into_iter().enumerate() {
            let side = approach.map_or(0.0, |approach| approach[k + 1]);
            let otherwise = side * step < 0.0 && step.abs() > self.poses.still[joint];
            state = next(state, if otherwise { side * f64::INFINITY } else { step });
            states.push(state);
        }
        self.pose.iter().map(|&pose| states[pose]).collect()
    }

    /// The load of a joint in the nominal posture of every pose, N·m or N; none of a joint that does not move.
    pub(super) fn loads(&self, joint: JointId, chain: &Chain) -> Vec<f64> {
        let Some(column) = chain.coordinate(joint) else { return Vec::new() };
        let poses = &self.poses;
        poses.nominal.of(chain, (&poses.joints, &poses.load)).column(column).iter().copied().collect()
    }

    /// A state at every row: `first` at the first pose, then what `next` makes of it, of the pose before and of the seconds to the next one.
    /// Poses of one instant share a state.
    pub(super) fn follow_time(&self, first: f64, next: impl Fn(f64, usize, f64) -> f64) -> Vec<f64> {
        let mut state = first;
        let mut states = vec![first];
        for (k, pair) in self.poses.time.windows(2).enumerate() {
            let h = pair[1] - pair[0];
            if h > 0.0 {
                state = next(state, k, h);
            }
            states.push(state);
        }
        self.pose.iter().map(|&pose| states[pose]).collect()
    }
}
