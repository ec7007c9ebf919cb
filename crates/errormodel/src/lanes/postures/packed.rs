//! Without what is zero for every robot, and without what is there twice.

use super::{Blocks, fits};
use crate::ModelError;
use crate::lanes::LANES;
use truepose_kinematics::Chain;

/// Numbers of a frame in the packed layout: its axes, then its levers.
pub const PACKED: usize = 18;

/// The numbers of which [`super::error_jacobians`] consists, half as many: no zeros and nothing twice.
///
/// `joints` has a column a movable joint, values of its variable, rad or m; everything is in the measurement frame. `into` has as many blocks of [`LANES`] postures as are begun, each with `n × 18 × LANES` numbers: of each joint's frame the axes ω_x, ω_y, ω_z
/// and then the levers ω_k × (p − o), m per rad, each by its components x, y, z, in each the postures. With them the frame's six columns are
///
/// ```text
/// J_e = [ ω_x ω_y ω_z   l_x l_y l_z ]   position
///       [  0   0   0    ω_x ω_y ω_z ]   rotation
/// ```
///
/// # Errors
/// When sizes do not fit.
pub fn error_jacobians_packed(chain: &Chain, joints: &[&[f64]], into: &mut [f64]) -> Result<(), ModelError> {
    let mut blocks = Blocks::new(chain, joints)?;
    let size = PACKED * blocks.frames() * LANES;
    fits("numbers of the Jacobians", into.len(), blocks.count() * size)?;
    for (block, into) in into.chunks_exact_mut(size.max(1)).enumerate() {
        let (store, _) = blocks.at(block);
        for (frame, into) in into.chunks_exact_mut(PACKED * LANES).enumerate() {
            let (axes, levers) = into.split_at_mut(9 * LANES);
            axes.copy_from_slice(store.rows(store.before(frame + 1), 9));
            levers.copy_from_slice(store.rows(store.lever(frame + 1), 9));
        }
    }
    Ok(())
}
