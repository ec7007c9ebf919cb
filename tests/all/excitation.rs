//! What more varied data would excite, what targets on a line leave open, and what a channel that numbers folds does.

use crate::plants::{geometric, geometric_plant, with_three_targets};
use nalgebra::Vector3;
use truepose_identify::reduction::Cause;
use truepose_identify::{Excitation, FitOptions, excitation, fit, place};
use truepose_kinematics::{Placed, Pose, Target, samples};
use truepose_simulate::{Campaign, Instrument, Plant};
use truepose_solvers::PivotedQr;

/// Noise of a tracker, 20 µm an axis: without noise every direction is determined.
fn noisy(mut plant: Plant) -> Plant {
    plant.instrument = Instrument { sd: 20e-6, ..Instrument::default() };
    plant
}

#[test]
fn a_joint_that_hardly_moves_is_named_first() {
    let chain = with_three_targets(&samples::ur10());
    let plant = noisy(geometric_plant(&chain, 5));
    let mut campaign = Campaign::random(&chain, 80, 3).unwrap();
    for visit in &mut campaign.visits {
        visit.joints[4] *= 0.001;
    }
    let data = plant.measure(&campaign, 8).unwrap();
    let found = fit(&geometric(&chain), &data, &PivotedQr::default(), &FitOptions::default()).unwrap();
    let Excitation { weak_directions: weak, advice, .. } = excitation(&found, &data).unwrap();
    assert!(weak > 0, "j5 over ±0.36° hides its neighbours' errors from each other");
    assert_eq!(chain.joint(advice[0].joint).name, "j5", "{advice:?}");
    assert!(advice[0].seen.upper - advice[0].seen.lower < 0.02);
    assert_eq!(advice[0].gains, weak, "moving it determines all of them");
}

#[test]
fn a_joint_that_stands_still_is_unexcited_and_named() {
    let chain = with_three_targets(&samples::ur10());
    let plant = noisy(geometric_plant(&chain, 5));
    let mut campaign = Campaign::random(&chain, 60, 3).unwrap();
    for visit in &mut campaign.visits {
        visit.joints[2] = 0.4;
    }
    let data = plant.measure(&campaign, 8).unwrap();
    let found = fit(&geometric(&chain), &data, &PivotedQr::default(), &FitOptions::default()).unwrap();
    let unexcited = found.reduction.dropped.iter().filter(|d| d.cause == Cause::Unexcited).count();
    assert_eq!(unexcited, 4, "of six errors at a turning joint, two can pass it in any case");
    let Excitation { weak_directions: weak, advice, .. } = excitation(&found, &data).unwrap();
    assert!(weak >= 4);
    assert_eq!(chain.joint(advice[0].joint).name, "j3", "{advice:?}");
}

#[test]
fn varied_data_needs_no_advice() {
    let chain = with_three_targets(&samples::ur10());
    let data =
        noisy(geometric_plant(&chain, 5)).measure(&Campaign::random(&chain, 80, 3).unwrap(), 8).unwrap();
    let found = fit(&geometric(&chain), &data, &PivotedQr::default(), &FitOptions::default()).unwrap();
    assert_eq!(excitation(&found, &data).unwrap(), Excitation::default());
}

#[test]
fn targets_on_a_line_leave_the_turn_about_it_open() {
    let on_a_line = |k: usize| Target {
        name: format!("T{k}"),
        position: Vector3::new(0.1, 0.02, 0.05) + Vector3::new(0.05, -0.03, 0.02) * k as f64,
        known: true,
        tool: truepose_kinematics::ToolId::FIRST,
    };
    let chain = samples::ur10().with_targets((0..3).map(on_a_line).collect()).unwrap();
    let data = geometric_plant(&chain, 2).measure(&Campaign::random(&chain, 40, 6).unwrap(), 1).unwrap();
    let blank = chain.clone().with_tool(Placed { pose: Pose::IDENTITY, known: false }).unwrap();
    // The plant's targets are a tenth of a millimetre off the line: the angle is all but free, and that is what is said.
    let exact = {
        let mut exact = data.clone();
        for row in 0..exact.len() {
            let joints: Vec<f64> = exact.joints.iter().map(|column| column[row]).collect();
            let target = exact.target[row].unwrap();
            exact.position[row] = chain.forward(&joints).apply(&chain.targets()[target.0].position).into();
        }
        exact
    };
    let placed = place(&blank, &exact).unwrap();
    assert!(placed.rms < 1e-9, "{} m", placed.rms);
    assert_eq!(placed.undetermined.len(), 1, "{:?}", placed.undetermined);
    assert!(placed.undetermined[0].what.starts_with("one direction of "), "{:?}", placed.undetermined);
    assert_eq!(placed.undetermined[0].advice, "all targets lie on one line: add one beside it");
}
