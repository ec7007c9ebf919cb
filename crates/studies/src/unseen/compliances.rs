//! Compliances of the declared model.

use super::stream::Draw;
use truepose_kinematics::{Chain, JointId};
use truepose_simulate::flaws;

/// The declared errors' own compliances: drives that turn by 0.05 to 0.4 mrad under their largest load, times a factor.
pub fn compliances(
    chain: &Chain,
    loads: &[f64],
    factor: f64,
    draw: &mut Draw,
) -> Vec<flaws::JointCompliance> {
    let largest = loads.iter().copied().fold(1e-3, f64::max);
    let one = |(k, &joint): (usize, &JointId)| flaws::JointCompliance {
        joint: chain.joint(joint).name.clone(),
        stiffness: Some(loads[k].max(0.05 * largest) / (1e-3 * factor * draw.logarithmic(0.05, 0.4))),
        ..flaws::JointCompliance::default()
    };
    chain.movable().iter().enumerate().map(one).collect()
}
