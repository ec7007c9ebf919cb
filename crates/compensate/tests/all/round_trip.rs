//! predict(command(x)) = x, for robots of every kind; what cannot be reached is never `ok`.

use crate::fits::{Draw, beside, fitted, load, target_at};
use truepose_compensate::{Approach, Command, Compensator, CompensatorOptions, Status, Target};
use truepose_errormodel::{FittedModel, Schema};
use truepose_kinematics::nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Chain, Conditions, Joint, JointId, Pose, TargetId, rotation_log, samples};

fn schema() -> Schema {
    Schema { channels: vec![], time: true, load: true, approach: true }
}

fn bound(fit: &FittedModel) -> Compensator<'_> {
    Compensator::bind(fit, &schema(), CompensatorOptions::default()).expect("bound")
}

/// Where the model's own evaluation says that a command ends.
fn ends(fit: &FittedModel, conditions: &Conditions, command: &Command, target: Option<TargetId>) -> Pose {
    let mut at = conditions.clone();
    at.joints = command.joints.to_vec();
    at.approach = command.approach.to_vec();
    fit.bind(&schema()).expect("a predictor").predict(&at, target)
}

fn apart(a: &Pose, b: &Pose) -> (f64, f64) {
    ((a.translation - b.translation).norm(), rotation_log(&(a.rotation * b.rotation.transpose())).norm())
}

/// Round trips over random poses within the limits; returns how many were not ok.
fn round_trips(chain: &Chain, poses: usize, seeded: bool) -> usize {
    let fit = fitted(chain, 5);
    let mut compensator = bound(&fit);
    let mut predictor = fit.bind(&schema()).expect("a predictor");
    let mut draw = Draw(11);
    let mut failed = 0;
    for k in 0..poses {
        let mut conditions = Conditions::at(chain, &draw.joints(chain, 0.97));
        if k % 2 == 1 {
            conditions.load = load(chain);
        }
        let id = if chain.targets().is_empty() || k % 3 == 0 { None } else { Some(TargetId(k % 3)) };
        let wanted = predictor.predict(&conditions, id);
        let seed = beside(&conditions, 0.02, &mut draw);
        let command =
            compensator.command(&target_at(&wanted).of(id), &conditions, seeded.then_some(&seed[..]));
        for (q, &joint) in command.joints.iter().zip(chain.movable()) {
            let (lower, upper) = chain.joint(joint).limits.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            assert!(*q >= lower && *q <= upper, "{}: {q} beyond {lower} … {upper}", chain.name());
        }
        if command.status == Status::Ok {
            let (p, r) = apart(&ends(&fit, &conditions, &command, id), &wanted);
            assert!(p < 1e-9 && r < 1e-9, "{} pose {k}: {p:e} m, {r:e} rad", chain.name());
        } else {
            failed += 1;
        }
    }
    failed
}

#[test]
fn every_pose_comes_back_from_a_seed_beside_it() {
    for chain in samples::all() {
        let failed = round_trips(&chain, 2000, true);
        assert_eq!(failed, 0, "{}", chain.name());
    }
}

#[test]
fn nearly_every_pose_comes_back_without_a_seed() {
    for chain in samples::all() {
        let failed = round_trips(&chain, 400, false);
        assert!(failed <= 2, "{}: {failed} of 400", chain.name());
    }
}

#[test]
fn positions_alone_keep_the_seeds_orientation() {
    for chain in samples::all() {
        let fit = fitted(&chain, 5);
        let mut compensator = bound(&fit);
        let mut predictor = fit.bind(&schema()).expect("a predictor");
        let mut draw = Draw(3);
        for _ in 0..200 {
            let here = Conditions::at(&chain, &draw.joints(&chain, 0.6));
            let begin = predictor.predict(&here, None);
            let away = Vector3::new(draw.next(), draw.next(), draw.next()) * 0.01;
            let target = Target::at(begin.translation + away);
            let command = compensator.command(&target, &here, Some(&here.joints));
            if command.status != Status::Ok {
                continue;
            }
            let end = ends(&fit, &here, &command, None);
            let (p, r) = apart(&end, &Pose::new(begin.rotation, target.position));
            assert!(p < 1e-9, "{}: {p:e}", chain.name());
            assert!(command.orientation_error.abs() < f64::MIN_POSITIVE);
            if r > 1e-9 {
                // Only where no posture beside the seed has both: stretched out, singular or at a limit.
                let both = target_at(&Pose::new(begin.rotation, target.position));
                let other = compensator.command(&both, &here, Some(&here.joints));
                let beside = other.joints.iter().zip(&here.joints).all(|(a, b)| (a - b).abs() < 0.2);
                assert!(other.status != Status::Ok || !beside, "{}: turned by {r}", chain.name());
            }
            if chain.name() == "scara" {
                assert!(r < 2e-3, "{}: turned by {r}", chain.name());
            }
        }
    }
}

#[test]
fn out_of_reach_is_reported_with_its_size() {
    for chain in samples::all() {
        let fit = fitted(&chain, 5);
        let mut compensator = bound(&fit);
        let mut draw = Draw(23);
        for k in 0..20 {
            let conditions = Conditions::at(&chain, &draw.joints(&chain, 0.9));
            let pose = chain.forward(&conditions.joints);
            let away = Vector3::new(draw.next(), draw.next(), draw.next()).normalize() * 40.0;
            let target = target_at(&Pose::new(pose.rotation, pose.translation + away));
            let seed = (k % 2 == 0).then_some(&conditions.joints[..]);
            let command = compensator.command(&target, &conditions, seed);
            assert!(
                matches!(command.status, Status::Unreachable | Status::Limit),
                "{} {k}: {:?}",
                chain.name(),
                command.status
            );
            let (p, _) =
                apart(&ends(&fit, &conditions, &command, None), &Pose::new(pose.rotation, target.position));
            assert!((p - command.position_error).abs() < 1e-9, "{}: {p}", chain.name());
            // The skewed robot's slides have no end.
            assert!(p > 20.0 || chain.name() == "skewed", "{}: {p}", chain.name());
        }
    }
}

/// The chain with its limits cut to a share of what they were.
fn tighter(chain: &Chain, share: f64) -> Chain {
    let joints: Vec<Joint> = chain
        .joints()
        .iter()
        .cloned()
        .map(|mut joint| {
            if let Some((lower, upper)) = joint.limits {
                let (middle, half) = (0.5 * (lower + upper), 0.5 * share * (upper - lower));
                joint.limits = Some((middle - half, middle + half));
            }
            joint
        })
        .collect();
    let made = Chain::new(chain.name(), joints).expect("joints");
    let made = made.with_base(*chain.base()).expect("a base").with_tool(*chain.tool()).expect("a tool");
    let made = made.with_gravity(*chain.gravity()).expect("gravity");
    made.with_targets(chain.targets().to_vec()).expect("targets")
}

#[test]
fn beyond_the_limits_is_limit() {
    let mut limits = 0;
    for chain in [samples::pps(), samples::scara(), samples::heavy(), samples::seven()] {
        let tight = tighter(&chain, 0.4);
        let fit = fitted(&tight, 5);
        let mut compensator = bound(&fit);
        let mut predictor = fit.bind(&schema()).expect("a predictor");
        let mut draw = Draw(31);
        for k in 0..60 {
            let conditions = Conditions::at(&chain, &draw.joints(&chain, 1.0));
            let wanted = predictor.predict(&conditions, None);
            let seed = (k % 2 == 0).then_some(&conditions.joints[..]);
            let command = compensator.command(&target_at(&wanted), &conditions, seed);
            let (p, r) = apart(&ends(&fit, &conditions, &command, None), &wanted);
            match command.status {
                Status::Ok => assert!(p < 1e-9 && r < 1e-9),
                status => {
                    assert_eq!(status, Status::Limit, "{} {k}", chain.name());
                    assert!((p - command.position_error).abs() < 1e-9);
                    limits += 1;
                }
            }
        }
    }
    assert!(limits > 100, "{limits}");
}

#[test]
fn a_scara_that_is_asked_to_tilt_has_its_position_with_a_message() {
    let chain = samples::scara();
    let fit = fitted(&chain, 5);
    let mut compensator = bound(&fit);
    // Its errors tilt the tool by some tenths of a milliradian: the nominal, upright pose is out of reach.
    let conditions = Conditions::at(&chain, &[0.4, 0.9, 0.1, -0.3]);
    let upright = target_at(&chain.forward(&conditions.joints));
    let command = compensator.command(&upright, &conditions, Some(&conditions.joints));
    assert_eq!(command.status, Status::Unreachable);
    assert!(command.position_error < 1e-9, "{:e}", command.position_error);
    assert!((1e-5..2e-3).contains(&command.orientation_error), "{:e}", command.orientation_error);
    let tolerant = CompensatorOptions { orientation_tolerance: 5e-3, ..Default::default() };
    let mut compensator = Compensator::bind(&fit, &schema(), tolerant).expect("bound");
    assert_eq!(compensator.command(&upright, &conditions, None).status, Status::Ok);
}

#[test]
fn backlash_follows_the_direction_of_the_move() {
    let chain = samples::ur10();
    let fit = crate::fits::with_backlash(&chain, JointId(1), 2e-4);
    let options = CompensatorOptions { approach: Approach::FromSeed, ..Default::default() };
    let mut compensator = Compensator::bind(&fit, &schema(), options).expect("bound");
    let goal = [0.3, -1.0, 0.7, 0.2, -0.5, 1.1];
    let target = target_at(&chain.forward(&goal));
    let conditions = Conditions::at(&chain, &goal);
    for (off, side) in [(-0.1, 1.0), (0.1, -1.0)] {
        let mut seed = goal;
        seed[0] += off;
        let command = compensator.command(&target, &conditions, Some(&seed));
        assert_eq!(command.status, Status::Ok);
        assert!(command.approach_holds);
        assert!((command.approach[0] - side).abs() < 1e-15);
        // It comes from below: the play holds it back by half, so that the command is that much further.
        assert!((command.joints[0] - goal[0] - side * 2e-4).abs() < 1e-9, "{}", command.joints[0] - goal[0]);
        let (p, r) = apart(&ends(&fit, &conditions, &command, None), &chain.forward(&goal));
        assert!(p < 1e-9 && r < 1e-9);
    }
    // From within the play no straight move does it: the command holds for the side that it states.
    let command = compensator.command(&target, &conditions, Some(&goal));
    assert_eq!(command.status, Status::Ok);
    let (p, _) = apart(&ends(&fit, &conditions, &command, None), &chain.forward(&goal));
    assert!(p < 1e-9, "{p:e}");
}

#[test]
fn what_is_no_number_is_refused_without_a_word() {
    for chain in samples::all() {
        let fit = fitted(&chain, 5);
        let mut compensator = bound(&fit);
        let good = Conditions::at(&chain, &Draw(1).joints(&chain, 0.5));
        let pose = chain.forward(&good.joints);
        let fine = target_at(&pose);
        let n = good.joints.len();
        let mut check = |target: &Target, conditions: &Conditions, seed: Option<&[f64]>| {
            let command = compensator.command(target, conditions, seed);
            assert_eq!(command.status, Status::NotConverged, "{}", chain.name());
            assert!(command.joints.iter().all(|q| q.is_finite()));
        };
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            check(&Target { position: Vector3::new(0.0, bad, 0.0), ..fine }, &good, None);
            check(&fine.turned(Matrix3::from_element(bad)), &good, None);
            check(&fine, &Conditions { time: bad, ..good.clone() }, None);
            check(&fine, &good, Some(&vec![bad; n]));
            let load = truepose_kinematics::Payload { mass: bad, com: Vector3::zeros() };
            check(&fine, &good.clone().with_load(truepose_kinematics::Load::Payload(load)), None);
            check(&fine, &Conditions { approach: vec![bad; n], ..good.clone() }, None);
        }
        check(&fine.turned(Matrix3::zeros()), &good, None);
        check(&fine.turned(-Matrix3::identity()), &good, None);
        check(&fine, &good, Some(&[0.0]));
        check(&fine.of(Some(TargetId(99))), &good, None);
        check(&fine, &Conditions { approach: vec![1.0], ..good.clone() }, None);
        // Absurd but finite numbers are answered, not with ok.
        let far = Target { position: Vector3::new(1e200, 0.0, 0.0), ..fine };
        assert_ne!(compensator.command(&far, &good, Some(&vec![1e12; n])).status, Status::Ok);
        let heavy = truepose_kinematics::Payload { mass: 1e200, com: Vector3::zeros() };
        let overloaded = good.clone().with_load(truepose_kinematics::Load::Payload(heavy));
        let command = compensator.command(&fine, &overloaded, None);
        assert!(command.joints.iter().all(|q| q.is_finite()));
    }
}

#[test]
fn missing_signals_are_refused_when_it_is_bound() {
    let chain = samples::ur10();
    let fit = crate::fits::with_backlash(&chain, JointId(1), 2e-4);
    let blind = Schema { approach: false, ..schema() };
    let refused = Compensator::bind(&fit, &blind, CompensatorOptions::default()).expect_err("no approach");
    assert!(refused.to_string().contains("approach of joint `j1`"), "{refused}");
}

#[test]
fn equal_requests_give_equal_commands() {
    let chain = samples::seven();
    let fit = fitted(&chain, 5);
    let (mut one, mut other) = (bound(&fit), bound(&fit));
    let mut draw = Draw(8);
    for _ in 0..20 {
        let conditions = Conditions::at(&chain, &draw.joints(&chain, 0.8));
        let target = target_at(&chain.forward(&conditions.joints));
        // The other one has just done something else.
        other.command(&Target::at(Vector3::new(0.3, 0.2, 0.5)), &conditions, None);
        let (a, b) = (one.command(&target, &conditions, None), other.command(&target, &conditions, None));
        assert_eq!(a, b);
    }
}
