//! Plants that are not the model, identified from noisy data and then driven with commands: they end where they should.

use truepose_compensate::{Compensator, CompensatorOptions, Status, Target};
use truepose_errormodel::effects::{Geometric, JointCompliance};
use truepose_errormodel::{ErrorModel, FittedModel, Schema};
use truepose_identify::{FitOptions, fit};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Conditions, Load, Payload, TargetId, samples};
use truepose_simulate::{Campaign, Plant, PlantDescription, PlantOptions, robots};
use truepose_solvers::PivotedQr;

/// Standard deviation an axis of what a robot does differently each time, µm.
const REPEATABILITY_UM: f64 = 20.0;

/// Geometry, and drives that yield; every joint of a robot that carries something.
fn plant(chain: &Chain, stiffness: f64) -> Plant {
    let mut text = format!(
        "[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.4\ntarget_mm = 0.1\n\
         [instrument]\nsd_um = 10\norientation_urad = 20\n[repeatability]\nsd_um = {REPEATABILITY_UM}\n"
    );
    for &joint in chain.movable() {
        let name = &chain.joint(joint).name;
        // N·m/rad; a slide's drive is about as stiff at an arm of 0.3 m.
        let size = if chain.joint(joint).unit() == "m" { 10.0 * stiffness } else { stiffness };
        text += &format!("[[errors.joint_compliance]]\njoint = \"{name}\"\nstiffness = {size:e}\n");
    }
    let PlantDescription { errors, shop, instrument, repeatability, .. } =
        PlantDescription::from_toml(&text).expect("a description");
    Plant::random(chain, &PlantOptions { errors, shop, instrument, repeatability }, 3).expect("a plant")
}

fn identified(plant: &Plant, mass: f64) -> FittedModel {
    let chain = plant.chain();
    let campaign = Campaign::random(chain, 160, 11).expect("a campaign");
    let campaign = campaign.with_each_payload(&[0.0, mass], [0.02, -0.01, 0.1]).shuffled(5);
    let data = plant.measure(&campaign, 7).expect("data");
    let effects: Vec<Box<dyn truepose_errormodel::AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())];
    let model = ErrorModel::new(chain.clone(), effects).expect("a model");
    fit(&model, &data, &PivotedQr::default(), &FitOptions::default()).expect("a fit").fitted
}

/// Distance from the desired position, root mean square over new poses, m: without and with compensation, without the
/// part that differs each time.
fn misses(plant: &Plant, fitted: &FittedModel, mass: f64) -> (f64, f64) {
    let chain = plant.chain();
    let schema = Schema { load: true, ..Schema::default() };
    let mut compensator =
        Compensator::bind(fitted, &schema, CompensatorOptions::default()).expect("a compensator");
    let load = Load::Payload(Payload { mass, com: Vector3::new(0.02, -0.01, 0.1) });
    let (mut before, mut after, mut count) = (0.0, 0.0, 0.0);
    for visit in &Campaign::random(chain, 80, 99).expect("a campaign").visits {
        let nominal = Conditions::at(chain, &visit.joints).with_load(load);
        let id = (!chain.targets().is_empty()).then_some(TargetId(1));
        let pose = chain.forward(&visit.joints);
        let position = pose.apply(&id.map_or(Vector3::zeros(), |t| chain.targets()[t.0].position));
        let mut wanted = Target::at(position).of(id);
        if visit.joints.len() >= 6 {
            wanted = wanted.turned(pose.rotation);
        }
        let command = compensator.command(&wanted, &nominal, Some(&visit.joints));
        if command.status != Status::Ok {
            // Only poses at the edge of what the real robot reaches: stretched out, or at a limit.
            continue;
        }
        let mut commanded = nominal.clone();
        commanded.joints = command.joints.to_vec();
        before += (plant.true_position(&nominal, id).expect("a position") - position).norm_squared();
        after += (plant.true_position(&commanded, id).expect("a position") - position).norm_squared();
        count += 1.0;
    }
    assert!(count > 60.0, "{}: only {count} of 80", chain.name());
    (f64::sqrt(before / count), f64::sqrt(after / count))
}

#[track_caller]
fn check(chain: &Chain, stiffness: f64, mass: f64) {
    let plant = plant(chain, stiffness);
    let fitted = identified(&plant, mass);
    let (before, after) = misses(&plant, &fitted, mass);
    let repeatability = f64::sqrt(3.0) * 1e-6 * REPEATABILITY_UM;
    // Together with what differs each time: root of the sum of squares.
    let together = after.hypot(repeatability);
    assert!(before > 10.0 * repeatability, "{}: {before:e} before", chain.name());
    assert!(
        together < 1.1 * repeatability,
        "{}: {before:e} m before, {after:e} m after, repeatability {repeatability:e} m",
        chain.name()
    );
}

#[test]
fn a_small_arm_ends_within_its_repeatability() {
    check(&samples::ur10(), 2e4, 8.0);
}

#[test]
fn a_heavy_arm_ends_within_its_repeatability() {
    check(&samples::heavy(), 2e6, 90.0);
}

#[test]
fn the_papers_couch_ends_within_its_repeatability() {
    check(&samples::pps(), 5e5, 70.0);
}

#[test]
fn a_redundant_arm_ends_within_its_repeatability() {
    // Drives of 2e4 N·m/rad yield by 4 mm here; that moves the loads' own arms, and 20 µm of second order stay.
    check(&samples::seven(), 6e4, 5.0);
}

#[test]
fn a_scara_ends_within_its_repeatability() {
    check(&samples::scara(), 1e5, 3.0);
}

#[test]
fn a_gantry_ends_within_its_repeatability() {
    check(&robots::gantry().expect("a gantry"), 5e5, 20.0);
}
