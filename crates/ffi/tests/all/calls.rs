//! The functions of the header, called as C calls them.

#![allow(unsafe_code)]
#![allow(clippy::undocumented_unsafe_blocks, reason = "every pointer here is of a local variable, or null")]

use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};
use truepose_compensate::{Compensator, CompensatorOptions, Status, Target};
use truepose_errormodel::Schema;
use truepose_ffi::*;
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Conditions, Load, Payload, samples};

fn loaded(text: &str) -> *mut truepose_fit {
    let mut fit = null_mut();
    let code = unsafe { truepose_fit_parse(text.as_ptr().cast(), text.len(), &mut fit) };
    assert_eq!(code, TRUEPOSE_OK);
    fit
}

fn armed(fit: *const truepose_fit) -> *mut truepose_arm {
    let mut arm = null_mut();
    assert_eq!(unsafe { truepose_arm_new(fit, null(), &mut arm) }, TRUEPOSE_OK);
    arm
}

fn carrying(mass: f64) -> truepose_conditions {
    truepose_conditions {
        load: TRUEPOSE_LOAD_PAYLOAD,
        payload_mass: mass,
        payload_com: [0.0, 0.0, 0.1],
        wrench: [0.0; 6],
        time: 0.0,
        approach: null(),
        approach_count: 0,
        channels: null(),
        channel_count: 0,
    }
}

fn joints(n: usize, count: usize) -> Vec<f64> {
    let middle = [0.3, -1.0, 0.9, 0.3, 0.3, 0.3];
    (0..count).map(|k| middle[k % 6] + 0.4 * (0.7 * n as f64 + 1.9 * k as f64).sin()).collect()
}

fn text_of(pointer: *const std::ffi::c_char) -> String {
    unsafe { CStr::from_ptr(pointer) }.to_str().unwrap().to_owned()
}

#[test]
fn commands_and_predictions_are_those_of_the_library_and_allocate_nothing() {
    for fitted in [
        crate::fits::elastic(&samples::ur10()),
        crate::fits::coupled(),
        crate::fits::with_findings(&samples::ur10()),
    ] {
        let fit = loaded(&crate::fits::json(&fitted));
        let arm = armed(fit);
        // The arm keeps what it needs.
        unsafe { truepose_fit_free(fit) };
        let schema = Schema { load: true, time: true, approach: true, ..Schema::default() };
        let mut ours = Compensator::bind(&fitted, &schema, CompensatorOptions::default()).unwrap();
        let chain = fitted.chain();
        let load = Load::Payload(Payload { mass: 5.0, com: Vector3::new(0.0, 0.0, 0.1) });
        let theirs = carrying(5.0);
        for n in 0..50 {
            let values = joints(n, 6);
            let mut variables = values.clone();
            chain.joints_from_controller(&mut variables);
            let conditions = Conditions::at(chain, &variables).with_load(load);
            let pose = ours.predict(&conditions, None).unwrap();
            let mut predicted = truepose_pose::default();
            let mut found = values.iter().map(|q| q + 0.01).collect::<Vec<f64>>();
            let mut seed = found.clone();
            chain.joints_from_controller(&mut seed);
            let (mut code, mut answer) = (0, truepose_answer::default());
            let counted = allocation_counter::measure(|| unsafe {
                code = truepose_predict(arm, values.as_ptr(), 6, &theirs, TRUEPOSE_TOOL, &mut predicted);
                let desired = truepose_target {
                    position: predicted.position,
                    quaternion: predicted.quaternion,
                    has_orientation: 1,
                    target: TRUEPOSE_TOOL,
                };
                let q = found.as_mut_ptr();
                code += truepose_command(arm, &desired, &theirs, q, q, 6, &mut answer);
            });
            assert_eq!((code, counted.count_total), (TRUEPOSE_OK, 0));
            assert_eq!(
                (predicted.position, predicted.quaternion),
                (pose.translation.into(), pose.quaternion())
            );
            let turned = truepose_kinematics::Pose::rotation_from_quaternion(pose.quaternion());
            let wanted = Target::at(pose.translation).turned(turned);
            let command = ours.command(&wanted, &conditions, Some(&seed));
            assert_eq!(command.status, Status::Ok);
            let mut expected = command.joints.to_vec();
            chain.joints_to_controller(&mut expected);
            assert_eq!(found, expected);
            assert_eq!(answer.position_error.to_bits(), command.position_error.to_bits());
            assert!(found.iter().zip(&values).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {values:?}");
        }
        unsafe { truepose_arm_free(arm) };
    }
}

#[test]
fn held_joints_stay_and_need_a_seed() {
    let fit = loaded(&crate::fits::json(&crate::fits::elastic(&samples::seven())));
    let made = |hold: u32| {
        let mut options = unsafe { std::mem::zeroed::<truepose_options>() };
        assert_eq!(unsafe { truepose_options_default(&mut options) }, TRUEPOSE_OK);
        options.hold = hold;
        let mut arm = null_mut();
        let code = unsafe { truepose_arm_new(fit, &options, &mut arm) };
        (code, arm)
    };
    let (code, arm) = made(1 << 2);
    assert_eq!(code, TRUEPOSE_OK);
    let seed = joints(3, 7);
    let mut pose = truepose_pose::default();
    unsafe {
        assert_eq!(truepose_predict(arm, seed.as_ptr(), 7, null(), TRUEPOSE_TOOL, &mut pose), TRUEPOSE_OK);
        let mut position = pose.position;
        position[0] += 0.004;
        let desired = truepose_target {
            position,
            quaternion: pose.quaternion,
            has_orientation: 1,
            target: TRUEPOSE_TOOL,
        };
        let mut q = seed.clone();
        let at = q.as_mut_ptr();
        assert_eq!(truepose_command(arm, &desired, null(), seed.as_ptr(), at, 7, null_mut()), TRUEPOSE_OK);
        assert!(q[2].to_bits() == seed[2].to_bits() && (q[1] - seed[1]).abs() > 1e-6, "{q:?} {seed:?}");
        let code = truepose_command(arm, &desired, null(), null(), at, 7, null_mut());
        assert_eq!(code, TRUEPOSE_NOT_CONVERGED);
        truepose_arm_free(arm);
    }
    assert_eq!(made(1 << 7).0, TRUEPOSE_ERROR_ARGUMENT);
    unsafe { truepose_fit_free(fit) };
}

#[test]
fn one_fit_serves_many_threads() {
    let fit = loaded(&crate::fits::json(&crate::fits::elastic(&samples::ur10()))) as usize;
    let run = || {
        let arm = armed(fit as *const truepose_fit);
        let mut all = Vec::new();
        for n in 0..200 {
            let mut pose = truepose_pose::default();
            let code = unsafe {
                truepose_predict(arm, joints(n, 6).as_ptr(), 6, &carrying(3.0), TRUEPOSE_TOOL, &mut pose)
            };
            assert_eq!(code, TRUEPOSE_OK);
            all.push(pose.position);
        }
        unsafe { truepose_arm_free(arm) };
        all
    };
    let results: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(run)).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(results.iter().all(|other| *other == results[0]));
    unsafe { truepose_fit_free(fit as *mut truepose_fit) };
}

#[test]
fn wrong_use_is_a_code_and_writes_nothing() {
    let fit = loaded(&crate::fits::json(&crate::fits::elastic(&samples::ur10())));
    let arm = armed(fit);
    let good = truepose_target {
        position: [0.6, 0.2, 0.5],
        quaternion: [1.0, 0.0, 0.0, 0.0],
        has_orientation: 0,
        target: TRUEPOSE_TOOL,
    };
    let (seed, conditions) = (joints(0, 6), carrying(1.0));
    let call = |desired: *const truepose_target, conditions: *const truepose_conditions, count: usize| {
        let mut q = [7.0; 6];
        let code = unsafe {
            truepose_command(arm, desired, conditions, seed.as_ptr(), q.as_mut_ptr(), count, null_mut())
        };
        (code, q.iter().all(|v| v.to_bits() == 7f64.to_bits()))
    };
    assert_eq!(call(&good, &conditions, 6), (TRUEPOSE_OK, false));
    assert_eq!(call(null(), &conditions, 6), (TRUEPOSE_ERROR_NULL, true));
    assert_eq!(call(&good, &conditions, 5), (TRUEPOSE_ERROR_LENGTH, true));
    assert_eq!(call(&good, null(), 6), (TRUEPOSE_OK, false));
    let far = truepose_target { position: [30.0, 0.0, 0.0], ..good };
    assert_eq!(call(&far, null(), 6), (TRUEPOSE_UNREACHABLE, true));
    for (bad, code) in [
        (truepose_target { position: [f64::NAN, 0.0, 0.0], ..good }, TRUEPOSE_ERROR_NOT_FINITE),
        (truepose_target { has_orientation: 1, quaternion: [0.0; 4], ..good }, TRUEPOSE_ERROR_NOT_FINITE),
        (truepose_target { target: 99, ..good }, TRUEPOSE_ERROR_TARGET),
        (truepose_target { target: i32::MIN, ..good }, TRUEPOSE_ERROR_TARGET),
    ] {
        assert_eq!(call(&bad, null(), 6), (code, true), "{bad:?}");
    }
    let three = [0.0; 3];
    for (bad, code) in [
        (truepose_conditions { load: 9, ..conditions }, TRUEPOSE_ERROR_ARGUMENT),
        (truepose_conditions { payload_mass: -1.0, ..conditions }, TRUEPOSE_ERROR_ARGUMENT),
        (truepose_conditions { payload_mass: f64::INFINITY, ..conditions }, TRUEPOSE_ERROR_NOT_FINITE),
        (truepose_conditions { time: f64::NAN, ..conditions }, TRUEPOSE_ERROR_NOT_FINITE),
        (truepose_conditions { approach_count: 6, ..conditions }, TRUEPOSE_ERROR_NULL),
        (
            truepose_conditions { channels: three.as_ptr(), channel_count: 3, ..conditions },
            TRUEPOSE_ERROR_LENGTH,
        ),
    ] {
        assert_eq!(call(&good, &bad, 6), (code, true), "{bad:?}");
    }
    let unseeded = unsafe {
        let mut q = [7.0; 6];
        truepose_command(arm, &good, null(), null(), q.as_mut_ptr(), 6, null_mut())
    };
    assert_eq!(unseeded, TRUEPOSE_OK);
    let mut pose = truepose_pose::default();
    let infinite = [f64::INFINITY; 6];
    unsafe {
        let p = &mut pose;
        assert_eq!(truepose_predict(arm, infinite.as_ptr(), 6, null(), -1, p), TRUEPOSE_ERROR_NOT_FINITE);
        assert_eq!(truepose_predict(arm, null(), 6, null(), -1, p), TRUEPOSE_ERROR_NULL);
        assert_eq!(truepose_predict(null_mut(), seed.as_ptr(), 6, null(), -1, p), TRUEPOSE_ERROR_NULL);
        assert_eq!(truepose_predict(arm, seed.as_ptr(), 6, null(), -1, null_mut()), TRUEPOSE_ERROR_NULL);
        truepose_arm_free(arm);
        truepose_arm_free(null_mut());
        truepose_fit_free(fit);
        truepose_fit_free(null_mut());
    }
}

#[test]
fn a_fit_that_is_refused_has_its_reason() {
    let mut fit = std::ptr::dangling_mut::<truepose_fit>();
    let broken = "{\"format\": 1,\n \"robot\": 3}";
    let code = unsafe { truepose_fit_parse(broken.as_ptr().cast(), broken.len(), &mut fit) };
    assert_eq!((code, fit.is_null()), (TRUEPOSE_ERROR_FIT, true));
    assert!(text_of(truepose_last_error()).starts_with("fit:2:"), "{}", text_of(truepose_last_error()));
    let missing = CString::new("/nowhere/fit.json").unwrap();
    assert_eq!(unsafe { truepose_fit_read(missing.as_ptr(), &mut fit) }, TRUEPOSE_ERROR_FIT);
    assert!(text_of(truepose_last_error()).contains("there is no such file"));
    assert_eq!(unsafe { truepose_fit_read(null(), &mut fit) }, TRUEPOSE_ERROR_NULL);
    assert_eq!(unsafe { truepose_fit_parse(null(), 3, &mut fit) }, TRUEPOSE_ERROR_NULL);
    assert_eq!(unsafe { truepose_fit_read(missing.as_ptr(), null_mut()) }, TRUEPOSE_ERROR_NULL);
    let mut arm = null_mut();
    assert_eq!(unsafe { truepose_arm_new(null(), null(), &mut arm) }, TRUEPOSE_ERROR_NULL);
    for code in -9..5 {
        assert!(!text_of(truepose_message(code)).is_empty());
    }
}

#[test]
fn names_and_options_are_those_of_the_fit() {
    let fit = loaded(&crate::fits::json(&crate::fits::thermal()));
    unsafe {
        assert_eq!((truepose_fit_joints(fit), truepose_fit_channels(fit)), (6, 1));
        assert_eq!(text_of(truepose_fit_channel(fit, 0)), "temperature");
        assert!(truepose_fit_channel(fit, 1).is_null() && truepose_fit_joint(null(), 0).is_null());
        assert_eq!(
            (truepose_fit_joint_is_prismatic(fit, 0), truepose_fit_joint_is_prismatic(fit, 9)),
            (0, -1)
        );
        let mut target = 7;
        let unknown = c"nobody";
        assert_eq!(truepose_fit_target(fit, unknown.as_ptr(), &mut target), TRUEPOSE_ERROR_TARGET);
        assert_eq!(target, 7);
        let mut options = std::mem::zeroed();
        assert_eq!(truepose_options_default(&mut options), TRUEPOSE_OK);
        let mut arm = null_mut();
        options.position_tolerance = 0.0;
        assert_eq!(truepose_arm_new(fit, &options, &mut arm), TRUEPOSE_ERROR_ARGUMENT);
        assert!(text_of(truepose_last_error()).contains("position_tolerance"));
        // A channel that the model reads has to be there.
        let arm = armed(fit);
        let q = joints(1, 6);
        let mut pose = truepose_pose::default();
        assert_eq!(truepose_predict(arm, q.as_ptr(), 6, null(), -1, &mut pose), TRUEPOSE_ERROR_LENGTH);
        let mut at = |temperature: f64| {
            let given = [temperature];
            let conditions =
                truepose_conditions { channels: given.as_ptr(), channel_count: 1, ..carrying(0.0) };
            assert_eq!(truepose_predict(arm, q.as_ptr(), 6, &conditions, -1, &mut pose), TRUEPOSE_OK);
            pose.position[0]
        };
        assert!((at(20.0) - at(30.0)).abs() > 1e-9);
        truepose_arm_free(arm);
        truepose_fit_free(fit);
    }
}

#[test]
fn a_fit_of_several_sessions_wants_one_of_them() {
    let fit = loaded(&crate::fits::json(&crate::fits::in_two_halls()));
    unsafe {
        assert_eq!(truepose_fit_sessions(fit), 2);
        assert_eq!(text_of(truepose_fit_session(fit, 1)), "hall 2");
        assert!(truepose_fit_session(fit, 2).is_null());
        let mut arm = null_mut();
        assert_eq!(truepose_arm_new(fit, null(), &mut arm), TRUEPOSE_ERROR_FIT);
        assert!(text_of(truepose_last_error()).contains("several sessions"));
        let mut chosen = null_mut();
        assert_eq!(truepose_fit_in_session(fit, c"hall 3".as_ptr(), &mut chosen), TRUEPOSE_ERROR_ARGUMENT);
        let mut at = |name: &CStr| {
            assert_eq!(truepose_fit_in_session(fit, name.as_ptr(), &mut chosen), TRUEPOSE_OK);
            let arm = armed(chosen);
            let mut pose = truepose_pose::default();
            let q = joints(1, 6);
            assert_eq!(truepose_predict(arm, q.as_ptr(), 6, null(), TRUEPOSE_TOOL, &mut pose), TRUEPOSE_OK);
            truepose_arm_free(arm);
            truepose_fit_free(chosen);
            pose.position
        };
        let (here, there) = (at(c"hall 1"), at(c"hall 2"));
        // The second frame stands 2 m along x of the first.
        assert!((here[0] - there[0] - 2.0).abs() < 1e-12 && (here[1] - there[1]).abs() < 1e-12);
        truepose_fit_free(fit);
    }
}
