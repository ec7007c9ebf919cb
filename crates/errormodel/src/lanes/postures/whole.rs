//! All of it, zeros included.

use super::{Blocks, fits};
use crate::ModelError;
use crate::lanes::LANES;
use truepose_kinematics::Chain;

/// Error Jacobians of the tool at many postures of the nominal robot, into memory that is there (Eq. 6–7).
///
/// `joints` has a column a movable joint, values of its variable, rad or m. Everything is in the measurement frame: m per m and per rad, rad per rad.
/// `into` has as many blocks of [`LANES`] postures as are begun, each with `6 n × 6 × LANES` numbers: site by site of the n joints' frames (x, y,
/// z, rx, ry, rz), in each the components of position and rotation, in each the postures. Numbers of postures that are not there are those
/// of a robot at zero.
///
/// # Errors
/// When sizes do not fit.
pub fn error_jacobians(chain: &Chain, joints: &[&[f64]], into: &mut [f64]) -> Result<(), ModelError> {
    let mut blocks = Blocks::new(chain, joints)?;
    let size = 36 * blocks.frames() * LANES;
    fits("numbers of the Jacobians", into.len(), blocks.count() * size)?;
    for (block, into) in into.chunks_exact_mut(size.max(1)).enumerate() {
        let (store, _) = blocks.at(block);
        for (site, site_numbers) in into.chunks_exact_mut(6 * LANES).enumerate() {
            let site = chain.site_at(6 + site);
            for (component, to) in site_numbers.chunks_exact_mut(LANES).enumerate() {
                match store.of_site(site, component) {
                    Some(row) => to.copy_from_slice(store.row(row)),
                    None => to.fill(0.0),
                }
            }
        }
    }
    Ok(())
}
