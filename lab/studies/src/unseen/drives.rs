//! Every drive that carries a weight yields, each as it likes: what an arm does whose compliances nobody declared.

use super::stream::Draw;
use truepose_kinematics::{Chain, JointKind};
use truepose_simulate::Truth;

/// Of the largest moment, below which a joint carries nothing.
const CARRIES: f64 = 0.03;

/// A drive that yields.
#[derive(Debug, Clone)]
pub struct Drive {
    pub place: usize,
    pub name: String,
    /// Largest moment about its axis, N·m.
    pub load: f64,
}

/// The turning joints that carry a weight; `loads` are those of the movable joints.
pub fn drives(chain: &Chain, loads: &[f64]) -> Vec<Drive> {
    let turns = |index: usize| chain.joint(chain.movable()[index]).kind == JointKind::Revolute;
    let largest = (0..loads.len()).filter(|&k| turns(k)).map(|k| loads[k]).fold(0.0, f64::max);
    let carries = |k: &usize| turns(*k) && loads[*k] > CARRIES * largest;
    let drive = |k: usize| {
        let joint = chain.movable()[k];
        Drive { place: joint.index(), name: chain.joint(joint).name.clone(), load: loads[k] }
    };
    (0..loads.len()).filter(carries).map(drive).collect()
}

/// Each drive turns by this angle, rad, times 0.3 to 3 under its largest moment: a gear is chosen for its moment. `seed` is uniform in [0, 1).
pub fn soften(drives: &[Drive], truth: &mut Truth, angle: f64, seed: f64) {
    for drive in drives {
        let mut draw = Draw::of(seed.to_bits() ^ drive.place as u64, 0);
        truth.joints[drive.place].stiffness.drive = drive.load / (angle * draw.logarithmic(0.3, 3.0));
    }
}
