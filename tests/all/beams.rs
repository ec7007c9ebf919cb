//! One link of a rigid robot is a beam: whichever it is, the effect of that link reaches what noise allows on postures and loads
//! that the fit did not see.

use crate::plants::{geometric_plant, rms_to_truth_um, with_three_targets};
use truepose_errormodel::effects::{Geometric, LinkCompliance};
use truepose_errormodel::{AnyEffect, ErrorModel};
use truepose_identify::{FitOptions, fit};
use truepose_kinematics::{Chain, JointId, samples};
use truepose_simulate::physics::beam::Beam;
use truepose_simulate::{Campaign, Instrument, Plant, span};
use truepose_solvers::SolverSpec;

/// Of one axis, m: a good laser tracker.
const SD: f64 = 20e-6;
/// Of the effect, rad: what the heaviest payload turns the tip by.
const TURN: f64 = 1e-3;

/// Geometric errors, and this link as a beam that is softer in one plane than in the other.
fn plant(chain: &Chain, joint: JointId, payload: f64) -> Plant {
    let rigid = geometric_plant(chain, 5);
    let (root, tip) = span(chain, joint);
    let moment = payload * 9.81 * chain.characteristic_length();
    let soft = (tip - root).norm() * moment / TURN;
    let round = Beam::slender(root, tip, soft, 0.8 * soft).unwrap();
    let mut errors = rigid.truth().clone();
    // Designers lay a section square to its joint's axis, where that is not the link's own.
    let (along, axis) = ((tip - root).normalize(), chain.joint(joint).axis_behind());
    let section_y = if along.cross(&axis).norm() > 0.3 { axis } else { round.section_y };
    errors.joints[joint.index()].beam = Some(Beam { bending: [soft, 3.0 * soft], section_y, ..round });
    let mut plant = rigid.with_truth(errors).unwrap();
    plant.instrument = Instrument { sd: SD, ..Instrument::default() };
    plant
}

/// Held-out RMS over that of noise alone, without and with the effect.
fn ratios(chain: &Chain, joint: JointId, payload: f64) -> [f64; 2] {
    let plant = plant(chain, joint, payload);
    let campaign = |count, seed| {
        Campaign::random(chain, count, seed)
            .unwrap()
            .with_each_payload(&[0.0, 0.4 * payload, payload], [0.03, -0.05, 0.1])
            .shuffled(seed)
    };
    let train = plant.measure(&campaign(60, 1), 1).unwrap();
    let unseen = plant.observe(&campaign(40, 2), 2).unwrap();
    let solver = "qr".parse::<SolverSpec>().unwrap().build();
    let rigid: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let mut bent = rigid.clone();
    bent.push(Box::new(LinkCompliance::of(joint)));
    [rigid, bent].map(|effects| {
        let model = ErrorModel::new(chain.clone(), effects).unwrap();
        let found = fit(&model, &train, &*solver, &FitOptions::default()).unwrap();
        let bias = rms_to_truth_um(&found.fitted, &unseen) * 1e-6 / (SD * 3.0_f64.sqrt());
        1.0_f64.hypot(bias)
    })
}

fn check(chain: &Chain, payload: f64) {
    let chain = if chain.targets().is_empty() { with_three_targets(chain) } else { chain.clone() };
    let mut tried = 0;
    for &joint in chain.movable().iter().filter(|&&j| chain.link_length(j) > 0.0) {
        let [without, with] = ratios(&chain, joint, payload);
        println!("{} {}: {without:.3} → {with:.4}", chain.name(), chain.joint(joint).name);
        // About 60 unknowns from 1620 numbers leave 1.02 of the noise; a wrong shape leaves more.
        assert!(with < 1.06, "{} {}: {with}", chain.name(), chain.joint(joint).name);
        tried += 1;
    }
    assert!(tried >= 3, "{}: {tried} links", chain.name());
}

#[test]
fn every_link_of_a_heavy_arm() {
    check(&samples::heavy(), 100.0);
}

#[test]
fn every_link_of_a_light_arm() {
    check(&samples::ur10(), 10.0);
}

#[test]
fn every_link_of_the_papers_robot() {
    check(&samples::pps(), 70.0);
}

#[test]
fn every_link_of_a_scara_and_of_seven_joints() {
    check(&samples::scara(), 8.0);
    check(&samples::seven(), 10.0);
}

#[test]
fn every_link_of_an_odd_robot() {
    check(&samples::skewed(), 10.0);
}
