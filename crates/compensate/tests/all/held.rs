//! Joints that are held: they stay to the last bit, wherever they are, and the others take the correction.

use crate::fits::{Draw, fitted};
use truepose_compensate::{CompensateError, Compensator, CompensatorOptions, Status, Target};
use truepose_errormodel::Schema;
use truepose_kinematics::{Conditions, samples};

fn schema() -> Schema {
    Schema { channels: vec![], time: true, load: true, approach: true }
}

#[test]
fn a_held_joint_of_seven_stays_and_the_pose_is_reached() {
    let chain = samples::seven();
    let fit = fitted(&chain, 5);
    let mut exact = fit.bind(&schema()).expect("a predictor");
    for hold in [0, 2, 6] {
        let options = CompensatorOptions { hold: vec![hold], ..CompensatorOptions::default() };
        let mut held = Compensator::bind(&fit, &schema(), options).expect("bound");
        let mut free = Compensator::bind(&fit, &schema(), CompensatorOptions::default()).expect("bound");
        let mut draw = Draw(31);
        let (mut done, mut moved) = (0, 0.0f64);
        for _ in 0..60 {
            let seed = draw.joints(&chain, 0.7);
            let pose = chain.forward(&seed);
            let target = Target::at(pose.translation).turned(pose.rotation);
            let conditions = Conditions::at(&chain, &seed);
            let other = free.command(&target, &conditions, Some(&seed));
            moved = moved.max((other.joints[hold] - seed[hold]).abs());
            let command = held.command(&target, &conditions, Some(&seed));
            assert_eq!(command.joints[hold].to_bits(), seed[hold].to_bits());
            if command.status != Status::Ok {
                continue;
            }
            done += 1;
            let there = exact.predict(&Conditions::at(&chain, &command.joints), None);
            assert!((there.translation - pose.translation).norm() < 1e-9, "{command:?}");
            // No pose without a seed: it states where the joint is.
            assert_eq!(held.command(&target, &conditions, None).status, Status::NotConverged);
        }
        assert!(done > 40 && moved > 1e-6, "joint {hold}: {done} of 60, moved by {moved}");
    }
}

#[test]
fn a_held_joint_beyond_its_limits_stays_there() {
    let chain = samples::seven();
    let fit = fitted(&chain, 5);
    let (_, upper) = chain.joint(chain.movable()[0]).limits.expect("limits");
    let mut seed = Draw(3).joints(&chain, 0.5);
    seed[0] = upper + 0.05;
    let pose = chain.forward(&seed);
    let options = CompensatorOptions { hold: vec![0], ..CompensatorOptions::default() };
    let mut held = Compensator::bind(&fit, &schema(), options).expect("bound");
    let target = Target::at(pose.translation).turned(pose.rotation);
    let command = held.command(&target, &Conditions::at(&chain, &seed), Some(&seed));
    assert_eq!((command.status, command.joints[0].to_bits()), (Status::Ok, seed[0].to_bits()));
}

#[test]
fn what_cannot_be_held_is_an_error() {
    let fit = fitted(&samples::seven(), 5);
    let options = CompensatorOptions { hold: vec![7], ..CompensatorOptions::default() };
    let error = Compensator::bind(&fit, &schema(), options).expect_err("refused");
    assert!(matches!(error, CompensateError::Option { option: "hold", value: 7.0, .. }), "{error}");
}
