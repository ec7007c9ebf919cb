//! Effects of what a robot has done and carried before, declared by hand: fitted, predicted, and compensated on the plant itself.

use crate::plants::with_three_targets;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_compensate::{Compensator, CompensatorOptions, Status, Target};
use truepose_errormodel::effects::{Geometric, Grows, JointCompliance, LinkCompliance, Spot, Thermal};
use truepose_errormodel::{AnyEffect, Dataset, FittedModel, History};
use truepose_identify::{IdentificationOptions, identify};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Conditions, JointId, Load, Payload, TargetId, samples};
use truepose_simulate::physics::bridge::Ram;
use truepose_simulate::physics::creep::Creep;
use truepose_simulate::physics::heating::Heating;
use truepose_simulate::physics::joint_stiffness::JointStiffness;
use truepose_simulate::{Campaign, Plant, Truth};
use truepose_solvers::PivotedQr;

/// Poses all over, three loads in turn, a minute each.
fn campaign(chain: &Chain, poses: usize, heaviest: f64, seed: u64) -> Campaign {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let ranges: Vec<(f64, f64)> =
        chain.movable().iter().map(|&joint| chain.joint(joint).limits.unwrap_or((-1.8, 1.8))).collect();
    let one = |&(lower, upper): &(f64, f64), rng: &mut ChaCha8Rng| {
        let (lower, upper) = (lower.max(-1.8), upper.min(1.8));
        lower + (upper - lower) * rng.random::<f64>()
    };
    let postures = (0..poses).map(|_| ranges.iter().map(|range| one(range, &mut rng)).collect());
    let mut campaign = Campaign::of(postures.collect());
    campaign.visit_s = 60.0;
    for (k, visit) in campaign.visits.iter_mut().enumerate() {
        // Each load for a while, so that what comes late is seen.
        let mass = heaviest * [0.0, 0.5, 1.0][k / 5 % 3];
        visit.load = Load::Payload(Payload { mass, com: Vector3::new(0.02, -0.03, 0.15) });
    }
    campaign
}

/// 3-D RMS distance of the plant's first target from where it is wanted, m, with these joints in the same order.
fn missed(plant: &Plant, campaign: &Campaign, joints: Vec<Vec<f64>>, wanted: &[Vector3<f64>]) -> f64 {
    let mut there = campaign.clone();
    for (visit, joints) in there.visits.iter_mut().zip(joints) {
        visit.joints = joints;
    }
    there.targets = vec![Some(TargetId(0))];
    let seen = plant.observe(&there, 1).unwrap();
    let squares = seen.true_positions.iter().zip(wanted).map(|(at, wanted)| (at - wanted).norm_squared());
    (squares.sum::<f64>() / wanted.len() as f64).sqrt()
}

/// Commands for the nominal positions of a campaign, with the channels that follow from its own order.
fn commands(fitted: &FittedModel, rows: &Dataset, wanted: &[Vector3<f64>]) -> Vec<Vec<f64>> {
    let rows = rows.derived_for(fitted.model()).unwrap();
    let mut arm = Compensator::bind(fitted, &rows.schema, CompensatorOptions::default()).unwrap();
    let mut conditions = Conditions::default();
    let one = |(row, &wanted): (usize, &Vector3<f64>)| {
        rows.conditions_into(row, &mut conditions);
        let seed: Vec<f64> = rows.joints.iter().map(|column| column[row]).collect();
        let command = arm.command(&Target::at(wanted).of(Some(TargetId(0))), &conditions, Some(&seed));
        assert_eq!(command.status, Status::Ok);
        command.joints.to_vec()
    };
    wanted.iter().enumerate().map(one).collect()
}

/// Fits the declared effects to one campaign and compensates another: RMS of the plant without and with compensation, m.
fn round_trip(chain: &Chain, truth: Truth, right: Box<dyn AnyEffect>, heaviest: f64) -> [f64; 2] {
    let mut plant = Plant::new(chain, truth).unwrap();
    plant.repeatability.sd = 10e-6;
    let declared: Vec<Box<dyn AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default()), right];
    let data = plant.measure(&campaign(chain, 130, heaviest, 5), 5).unwrap();
    let options = IdentificationOptions::default();
    let found = identify(chain, &declared, &data, &PivotedQr::default(), &options, &|_| ()).unwrap();
    let fitted = found.fit.fitted;
    plant.repeatability.sd = 0.0;
    let mut fresh = campaign(chain, 60, heaviest, 6);
    fresh.targets = vec![Some(TargetId(0))];
    let nominal = Plant::perfect(chain).unwrap().observe(&fresh, 1).unwrap();
    let wanted = nominal.true_positions;
    let before = missed(&plant, &fresh, fresh.visits.iter().map(|v| v.joints.clone()).collect(), &wanted);
    let after = missed(&plant, &fresh, commands(&fitted, &nominal.data, &wanted), &wanted);
    [before, after]
}

fn soft(chain: &Chain, stiffness: f64) -> Truth {
    let mut truth = Truth::of(chain);
    truth.joints.iter_mut().for_each(|joint| joint.stiffness = JointStiffness::drive(stiffness));
    truth
}

#[test]
fn a_joint_that_heats_itself_is_compensated_by_its_moves() {
    let chain = with_three_targets(&samples::ur10());
    let joint = chain.movable()[1];
    let mut truth = soft(&chain, 2e5);
    let heating =
        Heating { friction: 10.0, motor_s: 300.0, gear_s: 500.0, near: 0.3, rate: 3e-3, by_load: false };
    truth.joints[joint.index()].heating = Some(heating);
    let effect = Thermal::by(Spot::Joint(joint), History::Travel(joint), 600.0);
    let right = Thermal { grows: Some(Grows::Motion), lag_range: Some([60.0, 3000.0]), ..effect };
    let [before, after] = round_trip(&chain, truth, right.boxed(), 5.0);
    assert!(before > 2e-4 && after < 0.12 * before, "{before:e} {after:e}");
}

#[test]
fn creep_is_compensated_by_what_was_carried() {
    let chain = with_three_targets(&samples::heavy());
    let joint = chain.movable()[1];
    let mut truth = soft(&chain, 4e6);
    truth.joints[joint.index()].creep = Some(Creep { compliance: 1e-7, time: 400.0, stretch: 0.7 });
    let right = JointCompliance { lag_range: Some([60.0, 3000.0]), ..JointCompliance::creep(joint, 400.0) };
    let [before, after] = round_trip(&chain, truth, right.boxed(), 150.0);
    assert!(before > 2e-4 && after < 0.12 * before, "{before:e} {after:e}");
}

#[test]
fn a_ram_is_compensated_over_its_extension() {
    let chain = with_three_targets(&samples::pps());
    let joint = JointId(1);
    let mut truth = soft(&chain, 1e7);
    let ram = Ram { length: 2.0, stiffness: 2e6, taper: 0.1, full: 4.0, bush: 1e7 };
    truth.joints[joint.index()].ram = Some(ram);
    let right = LinkCompliance { ram_range: Some([1.9, 4.0]), ..LinkCompliance::ram(joint, 2.5, false) };
    let [before, after] = round_trip(&chain, truth, right.boxed(), 100.0);
    assert!(before > 2e-4 && after < 0.12 * before, "{before:e} {after:e}");
}
