//! A robot with two hands on a torso that bends: one hand is brought to the other, and a command for one hand leaves the other's joints alone.

use crate::fits::{Draw, fitted};
use truepose_compensate::{CompensateError, Compensator, CompensatorOptions, Status, Target};
use truepose_errormodel::{FittedModel, Schema};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Conditions, FrameId, Pose, ToolId, samples};

const LEFT: ToolId = ToolId(0);
const RIGHT: ToolId = ToolId(1);

fn schema() -> Schema {
    Schema { channels: vec![], time: true, load: true, approach: true }
}

fn hand(fit: &FittedModel, joints: &[f64], tool: ToolId) -> Pose {
    let conditions = Conditions { tool, ..Conditions::at(fit.chain(), joints) };
    fit.bind(&schema()).expect("a predictor").predict(&conditions, None)
}

fn carries(chain: &Chain, k: usize, tool: ToolId) -> bool {
    chain.carries(FrameId(chain.movable()[k].0), tool)
}

#[test]
fn one_hand_is_brought_to_the_other_where_that_really_is() {
    let chain = samples::dual();
    let fit = fitted(&chain, 5);
    let options =
        CompensatorOptions { tool: LEFT, relative_to: Some(RIGHT), ..CompensatorOptions::default() };
    let mut compensator = Compensator::bind(&fit, &schema(), options).expect("bound");
    let mut draw = Draw(23);
    let (mut done, mut bent) = (0, 0.0f64);
    for _ in 0..60 {
        let there = draw.joints(&chain, 0.8);
        // Where the left hand is to be, in the axes of the right one; begun from elsewhere.
        let mut seed = there.clone();
        for (k, q) in seed.iter_mut().enumerate().filter(|(k, _)| !carries(&chain, *k, RIGHT)) {
            *q += 0.2 * ((3 * k) as f64).sin();
        }
        let wanted = hand(&fit, &there, RIGHT).inverse().apply(&hand(&fit, &there, LEFT).translation);
        let conditions = Conditions { tool: LEFT, ..Conditions::at(&chain, &seed) };
        let command = compensator.command(&Target::at(wanted), &conditions, Some(&seed));
        if command.status != Status::Ok {
            continue;
        }
        done += 1;
        let (left, right) = (hand(&fit, &command.joints, LEFT), hand(&fit, &command.joints, RIGHT));
        let off = (right.inverse().apply(&left.translation) - wanted).norm();
        assert!(off < 1e-9 && command.position_error < 1e-9, "{off} {}", command.position_error);
        for k in (0..seed.len()).filter(|&k| carries(&chain, k, RIGHT)) {
            assert_eq!(command.joints[k].to_bits(), seed[k].to_bits(), "joint {k}");
        }
        bent = bent.max((right.translation - hand(&fit, &seed, RIGHT).translation).norm());
    }
    assert!(done > 50, "{done}");
    // The weight of the left arm bends the torso: the right hand is not where it was.
    assert!(bent > 1e-7, "{bent}");
}

#[test]
fn the_other_arm_stays_wherever_a_search_begins() {
    let chain = samples::dual();
    let fit = fitted(&chain, 5);
    let options = CompensatorOptions { tool: LEFT, ..CompensatorOptions::default() };
    let mut compensator = Compensator::bind(&fit, &schema(), options).expect("bound");
    let mut draw = Draw(29);
    let mut elsewhere = 0;
    for _ in 0..60 {
        let (there, seed) = (draw.joints(&chain, 0.97), draw.joints(&chain, 0.97));
        let conditions = Conditions { tool: LEFT, ..Conditions::at(&chain, &seed) };
        let wanted = Target::at(hand(&fit, &there, LEFT).translation);
        let command = compensator.command(&wanted, &conditions, Some(&seed));
        for k in (0..seed.len()).filter(|&k| !carries(&chain, k, LEFT)) {
            assert_eq!(command.joints[k].to_bits(), seed[k].to_bits(), "joint {k}");
        }
        elsewhere += usize::from(command.rounds > 80);
    }
    assert!(elsewhere > 0);
}

#[test]
fn a_hand_needs_another_one_and_a_seed() {
    let chain = samples::dual();
    let fit = fitted(&chain, 5);
    for other in [LEFT, ToolId(2)] {
        let options = CompensatorOptions { relative_to: Some(other), ..CompensatorOptions::default() };
        let error = Compensator::bind(&fit, &schema(), options).expect_err("refused");
        assert!(matches!(error, CompensateError::Option { option: "relative_to", .. }), "{error}");
    }
    let options = CompensatorOptions { relative_to: Some(RIGHT), ..CompensatorOptions::default() };
    let mut compensator = Compensator::bind(&fit, &schema(), options).expect("bound");
    let conditions = Conditions::at(&chain, &[0.1; 8]);
    let command = compensator.command(&Target::at(Vector3::new(0.1, 0.0, 0.0)), &conditions, None);
    assert_eq!(command.status, Status::NotConverged);
}
