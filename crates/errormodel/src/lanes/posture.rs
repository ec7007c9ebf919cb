//! A block of postures, as effects see it.

use super::loads::LaneLoad;
use super::store::Store;
use super::width::LANES;
use std::cell::Cell;
use truepose_kinematics::pulp::Arch;
use truepose_kinematics::{Chain, FrameId, JointId};

/// The robot in each row of a block: `LANES` numbers of everything, of which those beyond the rows mean nothing and are finite.
#[derive(Debug, Clone, Copy)]
pub struct LanePosture<'a> {
    pub(crate) chain: &'a Chain,
    pub(crate) joints: &'a [f64],
    pub(crate) signals: &'a [f64],
    pub(crate) load: &'a LaneLoad,
    pub(crate) store: &'a Store,
    pub(crate) rows: usize,
    /// Set when somebody asks for what depends on where the frames are.
    pub(crate) asked: &'a Cell<bool>,
}

impl<'a> LanePosture<'a> {
    /// The robot.
    pub fn chain(&self) -> &'a Chain {
        self.chain
    }

    /// How many rows the block has: lanes beyond them may be left as they are.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Values of a joint, rad or m; none for a fixed joint.
    pub fn joint(&self, joint: JointId) -> Option<&'a [f64]> {
        self.chain.coordinate(joint).map(|k| &self.joints[k * LANES..][..LANES])
    }

    /// The k-th signal that the effect being evaluated asked for.
    pub fn signal(&self, k: usize) -> &'a [f64] {
        &self.signals[k * LANES..][..LANES]
    }

    /// Loads about (N·m) or along (N) a joint's axis.
    pub fn joint_load(&self, joint: JointId) -> &'a [f64] {
        self.asked.set(true);
        self.store.row(self.store.load(joint.index()))
    }

    /// Rows of [`LanePosture::numbers`] at which a frame's axes (nine, column after column) and its origin (three) begin, in the measurement frame.
    pub(crate) fn frame_rows(&self, frame: FrameId) -> (usize, usize) {
        self.asked.set(true);
        (self.store.behind(frame.0), self.store.place(frame.0))
    }

    /// The row at which what a frame carries begins: force and moment about its origin, in the measurement frame's axes.
    pub(crate) fn carried_row(&self, frame: FrameId) -> usize {
        self.asked.set(true);
        self.store.wrench(frame.0)
    }

    /// All rows of frames and weights, `LANES` numbers each.
    pub(crate) fn numbers(&self) -> &'a [f64] {
        &self.store.numbers
    }

    /// The processor's registers.
    pub(crate) fn arch(&self) -> Arch {
        self.store.arch
    }

    /// Writes a component (0…5: `[fx fy fz mx my mz]`) of the wrench that a frame carries, about its origin, in its axes: N, N·m.
    pub fn wrench(&self, frame: FrameId, component: usize, into: &mut [f64]) {
        if frame == self.chain.tool_frame() && self.load.measured && !self.store.branches() {
            into.copy_from_slice(self.load.component(component));
            return;
        }
        self.asked.set(true);
        let axis = self.store.behind(frame.0) + 3 * (component % 3);
        let of = self.store.wrench(frame.0) + 3 * (component / 3);
        into.fill(0.0);
        for k in 0..3 {
            let numbers = self.store.row(axis + k).iter().zip(self.store.row(of + k));
            into.iter_mut().zip(numbers).for_each(|(into, (r, w))| *into += r * w);
        }
    }
}
