//! Robots and data that several topics use.

use nalgebra::Vector3;
use truepose_errormodel::effects::{Geometric, JointCompliance};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel};
use truepose_kinematics::{Chain, JointKind, Pose, Target};
use truepose_simulate::physics::temperature::Shop;
use truepose_simulate::{Campaign, Flaws, Observation, Plant, flaws};

/// The same robot with three targets off every axis, and limits on slides that have none.
pub fn with_three_targets(chain: &Chain) -> Chain {
    let target = |name: &str, p: [f64; 3]| Target {
        name: name.into(),
        position: Vector3::from(p),
        known: true,
        tool: truepose_kinematics::ToolId::FIRST,
    };
    bounded(chain)
        .with_targets(vec![
            target("A", [0.12, 0.03, 0.05]),
            target("B", [-0.08, 0.11, 0.02]),
            target("C", [-0.05, -0.1, 0.14]),
        ])
        .unwrap()
}

/// The robot's first target alone.
pub fn with_one_target(chain: &Chain) -> Chain {
    let chain = with_three_targets(chain);
    let first = chain.targets()[..1].to_vec();
    chain.with_targets(first).unwrap()
}

/// The same robot with ±0.4 m for every slide without limits: a campaign needs to know how far it may go.
pub fn bounded(chain: &Chain) -> Chain {
    let joints = chain
        .joints()
        .iter()
        .map(|joint| match (joint.kind, joint.limits) {
            (JointKind::Prismatic, None) => joint.clone().with_limits(-0.4, 0.4),
            _ => joint.clone(),
        })
        .collect();
    Chain::new(chain.name(), joints)
        .and_then(|c| c.with_base(*chain.base()))
        .and_then(|c| c.with_tool(*chain.tool()))
        .and_then(|c| c.with_targets(chain.targets().to_vec()))
        .and_then(|c| c.with_gravity(*chain.gravity()))
        .unwrap()
}

/// A rigid robot with constant errors of half a millimetre and half a milliradian (one standard deviation) on every
/// frame and a tenth of a millimetre on every target, measured without noise.
pub fn geometric_plant(chain: &Chain, seed: u64) -> Plant {
    let geometric =
        flaws::Geometric { position_mm: 0.5, angle_mrad: 0.5, target_mm: 0.1, ..flaws::Geometric::default() };
    let flaws = Flaws { geometric: Some(geometric), ..Flaws::default() };
    let (truth, _) = flaws.on(chain, &Shop::steady(20.0).unwrap(), seed).unwrap();
    Plant::new(chain, truth).unwrap()
}

/// A heavy elastic arm: random postures, empty and loaded, everything twice, in no order.
pub fn heavy_observation(plant: &Plant, postures: usize, seed: u64) -> Observation {
    let campaign = Campaign::random(plant.chain(), postures, seed)
        .unwrap()
        .with_each_payload(&[0.0, 80.0], [0.02, -0.03, 0.15])
        .repeated(2)
        .shuffled(seed);
    plant.observe(&campaign, seed).unwrap()
}

/// Constant errors of everything.
pub fn geometric(chain: &Chain) -> ErrorModel {
    ErrorModel::new(chain.clone(), vec![Box::new(Geometric::default())]).unwrap()
}

/// Constant errors of everything, and joints that yield.
pub fn elastic(chain: &Chain) -> ErrorModel {
    ErrorModel::new(chain.clone(), elastic_effects()).unwrap()
}

/// What [`elastic`] is made of.
pub fn elastic_effects() -> Vec<Box<dyn AnyEffect>> {
    vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())]
}

/// Largest distance between what a model says and where the targets really are, and largest angle between tools;
/// in micrometres and microradians.
pub fn worst_um(fit: &truepose_errormodel::FittedModel, data: &Dataset, seen: &Observation) -> (f64, f64) {
    let mut predictor = fit.bind(&data.schema).unwrap();
    let (mut distance, mut angle) = (0.0f64, 0.0f64);
    for row in 0..data.len() {
        let pose = predictor.predict(&data.conditions(row), data.target[row]);
        let turned: Pose = seen.true_poses[row];
        distance = distance.max((pose.translation - seen.true_positions[row]).norm() * 1e6);
        let by = truepose_kinematics::rotation_log(&(turned.rotation * pose.rotation.transpose()));
        angle = angle.max(by.norm() * 1e6);
    }
    (distance, angle)
}

/// RMS distance between what a model says and where the targets really are, in micrometres.
pub fn rms_to_truth_um(fit: &truepose_errormodel::FittedModel, seen: &Observation) -> f64 {
    let data = &seen.data;
    let mut predictor = fit.bind(&data.schema).unwrap();
    let squares: f64 = (0..data.len())
        .map(|row| {
            let pose = predictor.predict(&data.conditions(row), data.target[row]);
            (pose.translation - seen.true_positions[row]).norm_squared()
        })
        .sum();
    (squares / data.len() as f64).sqrt() * 1e6
}
