//! Compliances of the declared model, and the loads that they are drawn for.

use super::robots::Robot;
use super::stream::Draw;
use std::error::Error;
use truepose_kinematics::{Chain, Conditions, JointId};
use truepose_simulate::{Campaign, Plant, flaws};

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

/// Largest load of each movable joint over random postures, N·m or N.
pub fn joint_loads(robot: &Robot) -> Result<Vec<f64>, Box<dyn Error>> {
    let plant = Plant::perfect(&robot.chain)?;
    let mut largest = vec![0.0f64; robot.chain.movable().len()];
    for visit in Campaign::halton(&robot.chain, 40)?.visits {
        let loads = plant.joint_loads(&Conditions::at(&robot.chain, &visit.joints))?;
        for (most, load) in largest.iter_mut().zip(loads) {
            *most = most.max(load.abs());
        }
    }
    Ok(largest)
}
