//! The error Jacobian of the nominal robot at many postures: as numbers in memory, or only what is made of them.
//!
//! | function | result | numbers written for each posture |
//! | --- | --- | --- |
//! | [`error_jacobians`] | J_e, 6 × 6n, zeros included | 36 n |
//! | [`error_jacobians_packed`] | the 18 numbers a frame of which the others are copies or zero | 18 n |
//! | [`JacobianGram`] | Σ J_eᵀJ_e, 6n × 6n | none |
//! | [`error_variances`] | diagonal of J_e C J_eᵀ | 6 |
//!
//! n joints, without base and tool: their frames are parallel to the first and the last one. The tool is the robot's first. `joints` has one
//! column a movable joint: values of the joints' variables (rad, m), all of one length. Everything is in the measurement frame.

mod gram;
mod packed;
mod variances;
mod whole;

pub use gram::JacobianGram;
pub use packed::{PACKED, error_jacobians_packed};
pub use variances::error_variances;
pub use whole::error_jacobians;

use super::errors::LaneErrors;
use super::store::Store;
use super::width::LANES;
use crate::ModelError;
use truepose_kinematics::Chain;

fn fits(what: &'static str, have: usize, need: usize) -> Result<(), ModelError> {
    if have == need { Ok(()) } else { Err(ModelError::Shape { what, have, need }) }
}

/// Postures of a robot, block by block.
struct Blocks<'a> {
    chain: &'a Chain,
    joints: &'a [&'a [f64]],
    postures: usize,
    store: Store,
    errors: LaneErrors,
    inputs: Vec<f64>,
    wanted: Vec<bool>,
}

impl<'a> Blocks<'a> {
    fn new(chain: &'a Chain, joints: &'a [&'a [f64]]) -> Result<Self, ModelError> {
        fits("joint columns", joints.len(), chain.movable().len())?;
        let postures = joints.first().map_or(0, |column| column.len());
        joints.iter().try_for_each(|column| fits("rows of a column", column.len(), postures))?;
        let mut store = Store::new(chain);
        store.take_first_tool();
        let frames = chain.joints().len();
        let wanted = (0..store.frames).map(|frame| (1..=frames).contains(&frame)).collect();
        let inputs = vec![0.0; joints.len() * LANES];
        Ok(Blocks { chain, joints, postures, store, errors: LaneErrors::new(chain), inputs, wanted })
    }

    /// How many there are; the last one may be filled with a robot at zero.
    fn count(&self) -> usize {
        self.postures.div_ceil(LANES)
    }

    /// Frames of the joints.
    fn frames(&self) -> usize {
        self.chain.joints().len()
    }

    /// Axes and levers in a block, and how many of its postures are there.
    fn at(&mut self, block: usize) -> (&mut Store, usize) {
        let first = block * LANES;
        let count = LANES.min(self.postures - first);
        for (to, from) in self.inputs.chunks_exact_mut(LANES).zip(self.joints) {
            to[..count].copy_from_slice(&from[first..first + count]);
            to[count..].fill(0.0);
        }
        self.store.turn(self.chain, &self.inputs);
        self.store.walk(self.chain, &self.inputs, &self.errors, LANES);
        self.store.reach(self.chain, &self.errors, &self.wanted, LANES);
        (&mut self.store, count)
    }
}

#[cfg(test)]
mod tests;
