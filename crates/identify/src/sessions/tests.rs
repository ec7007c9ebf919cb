use super::*;
use crate::{FitOptions, Residuals, fit};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{DatasetBuilder, ErrorModel, FittedModel, Measurement};
use truepose_kinematics::nalgebra::{DMatrix, Vector3};
use truepose_kinematics::{Conditions, samples};
use truepose_solvers::PivotedQr;

/// An arm with geometric errors, measured in sessions with these bases and so many poses each.
struct Campaign {
    robot: Chain,
    truth: FittedModel,
    data: Dataset,
    names: Vec<String>,
}

fn campaign(poses: &[usize], seed: u64) -> Campaign {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let targets = [[0.12, 0.0, 0.03], [-0.07, 0.09, 0.0], [0.0, -0.1, 0.05]].iter().enumerate();
    let targets = targets.map(|(k, at)| Target {
        name: format!("T{k}"),
        position: Vector3::from(*at),
        known: true,
        tool: truepose_kinematics::ToolId::FIRST,
    });
    let robot = samples::ur10().with_targets(targets.collect()).unwrap();
    let arm: Vec<_> = robot.frames().collect();
    let frames = arm[1..].iter().map(|&f| truepose_errormodel::effects::Where::Frame(f)).collect();
    let errors: Box<dyn AnyEffect> = Box::new(Geometric { frames: Some(frames), components: None });
    let model = ErrorModel::new(robot.clone(), vec![errors]).unwrap();
    let coefficients: Vec<f64> =
        model.columns().iter().map(|c| c.scale * rng.random_range(-1.5..1.5)).collect();
    let count = coefficients.len();
    let truth = FittedModel::new(model, coefficients, DMatrix::zeros(count, count)).unwrap();
    let mut builder = DatasetBuilder::new(&robot);
    let (mut sessions, mut visit) = (Vec::new(), 0);
    for (session, &poses) in poses.iter().enumerate() {
        let t: [f64; 3] = std::array::from_fn(|_| rng.random_range(-3.0..3.0));
        let yaw = rng.random_range(-3.0..3.0);
        // Instruments are levelled.
        let base = Pose::from_xyz_rpy(t, [0.0, 0.0, yaw]);
        let there = robot.clone().with_base(Placed { pose: base, known: true }).unwrap();
        let there = truth.on(there).unwrap();
        let mut predictor = there.bind(&Dataset::default().schema).unwrap();
        for _ in 0..poses {
            let joints: Vec<f64> = (0..6).map(|_| rng.random_range(-2.0..2.0)).collect();
            let at = Conditions { joints: joints.clone(), ..Conditions::default() };
            for target in 0..3 {
                let target = Some(TargetId(target));
                let noise = Vector3::from_fn(|_, _| 2e-5 * rng.random_range(-1.7..1.7));
                let position = predictor.predict(&at, target).translation + noise;
                let seen = Measurement::at(joints.clone()).position(position).target(target);
                builder.push(seen.visit(visit)).unwrap();
                sessions.push(session as f64);
            }
            visit += 1;
        }
    }
    let mut data = builder.finish();
    data.set_sessions(Some(sessions));
    let names = (0..poses.len()).map(|k| format!("S{k}")).collect();
    Campaign { robot: unplaced(&robot).unwrap(), truth, data, names }
}

fn fitted(of: &Campaign, rules: SessionRules) -> (Unified, FittedModel) {
    let unified = unify(&of.robot, &of.data, &of.names, rules).unwrap();
    let placed = place(&unified.chain, &unified.data).unwrap().chain;
    let mut effects: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    effects.extend(unified.effects.iter().cloned());
    let model = ErrorModel::new(placed, effects).unwrap();
    let found = fit(&model, &unified.data, &PivotedQr::default(), &FitOptions::default()).unwrap();
    let fitted = found.fitted.with_sessions(unified.installed.clone());
    (unified, fitted)
}

#[test]
fn three_installations_are_one_arm_and_each_predicts_in_its_own_frame() {
    let of = campaign(&[40, 25, 30], 3);
    let (unified, fitted) = fitted(&of, SessionRules::default());
    assert_eq!(unified.placed.iter().map(|s| s.poses).collect::<Vec<_>>(), [40, 25, 30]);
    for session in 0..3 {
        let there = fitted.in_session(session).unwrap();
        let rows: Vec<usize> = (0..of.data.len()).filter(|&r| of.data.session(r) == session).collect();
        let part = of.data.select(&rows);
        // As it was measured, in the session's own frame, without its number.
        let mut part = part;
        part.set_sessions(None);
        let rms = Residuals::of(&there, &part).unwrap().positions().rms;
        // Noise of 2e-5 · 1.7/√3 a component.
        assert!(rms < 1.1 * 2e-5 * 1.7, "session {session}: {rms}");
    }
    // The arm is that of the truth: between targets of new poses lies what lies there in truth, whatever the installation.
    let (there, mut rng) = (fitted.in_session(2).unwrap(), ChaCha8Rng::seed_from_u64(8));
    let (mut found, mut truth) =
        (there.bind(&Default::default()).unwrap(), of.truth.bind(&Default::default()).unwrap());
    let spots: Vec<[Vector3<f64>; 2]> = (0..20)
        .map(|_| {
            let joints: Vec<f64> = (0..6).map(|_| rng.random_range(-2.0..2.0)).collect();
            let at = Conditions { joints, ..Conditions::default() };
            [&mut found, &mut truth].map(|of| of.predict(&at, Some(TargetId(0))).translation)
        })
        .collect();
    for pair in spots.windows(2) {
        let apart = |k: usize| (pair[1][k] - pair[0][k]).norm();
        assert!((apart(0) - apart(1)).abs() < 6e-5, "{} m", apart(0) - apart(1));
    }
}

#[test]
fn what_cannot_be_placed_is_named() {
    let of = campaign(&[30, 1], 5);
    let mut data = of.data.select(&(0..91).collect::<Vec<_>>());
    data.record = None;
    let error = unify(&of.robot, &data, &of.names, SessionRules::default()).unwrap_err().to_string();
    assert!(error.starts_with("session S1: ") && error.contains("it has 1 pose;"), "{error}");
    // Another arm: the joint columns of the second session are those of no such arm.
    let mut other = campaign(&[30, 20], 7);
    for row in 90..other.data.len() {
        let (a, b) = (other.data.joints[1][row], other.data.joints[2][row]);
        (other.data.joints[1][row], other.data.joints[2][row]) = (b, a);
    }
    let error = unify(&other.robot, &other.data, &other.names, SessionRules::default());
    let error = error.unwrap_err().to_string();
    assert!(error.contains("session S1") && error.contains("another arm"), "{error}");
}

#[test]
fn a_tool_that_was_mounted_anew_has_errors_of_its_own() {
    let mut of = campaign(&[40, 30], 11);
    let moved = Pose::from_xyz_rpy([0.004, -0.002, 0.003], [0.02, -0.03, 0.01]);
    // What the second session measures with the tool as it is mounted there.
    let fitted_truth = &of.truth;
    let chain = fitted_truth.chain().clone();
    let shifted = chain.targets().iter().map(|t| Target { position: moved.apply(&t.position), ..t.clone() });
    let there = fitted_truth.on(chain.clone().with_targets(shifted.collect()).unwrap()).unwrap();
    let (mut here, mut there) =
        (fitted_truth.bind(&Default::default()).unwrap(), there.bind(&Default::default()).unwrap());
    // Its base is where the rows say: move each by what the tool moves it, turned into the session's frame.
    let part = of.data.select(&(120..of.data.len()).collect::<Vec<_>>());
    let base = place(&of.robot, &part).unwrap().chain.base().pose;
    for row in 120..of.data.len() {
        let at = of.data.conditions(row);
        let target = of.data.target[row];
        let by = there.predict(&at, target).translation - here.predict(&at, target).translation;
        let p = of.data.measured_position(row) + base.rotation * by;
        of.data.position[row] = p.into();
    }
    let (_, shared) = fitted(&of, SessionRules::default());
    let (_, own) = fitted(&of, SessionRules { tool: true, ..SessionRules::default() });
    let rms = |fit: &FittedModel| {
        let mut part = of.data.select(&(120..of.data.len()).collect::<Vec<_>>());
        part.set_sessions(None);
        Residuals::of(&fit.in_session(1).unwrap(), &part).unwrap().positions().rms
    };
    assert!(rms(&own) < 6e-5 && rms(&shared) > 1e-3, "{} {}", rms(&own), rms(&shared));
}

#[test]
fn a_tool_that_was_turned_about_is_found_by_its_points() {
    let mut of = campaign(&[40, 30], 13);
    let moved = Pose::from_xyz_rpy([0.03, -0.02, 0.05], [1.9, 0.4, -2.6]);
    let chain = of.truth.chain().clone();
    let turned = chain.targets().iter().map(|t| Target { position: moved.apply(&t.position), ..t.clone() });
    let there = of.truth.on(chain.clone().with_targets(turned.collect()).unwrap()).unwrap();
    let (mut here, mut there) =
        (of.truth.bind(&Default::default()).unwrap(), there.bind(&Default::default()).unwrap());
    let part = of.data.select(&(120..of.data.len()).collect::<Vec<_>>());
    let base = place(&of.robot, &part).unwrap().chain.base().pose;
    for row in 120..of.data.len() {
        let (at, target) = (of.data.conditions(row), of.data.target[row]);
        let by = there.predict(&at, target).translation - here.predict(&at, target).translation;
        of.data.position[row] = (of.data.measured_position(row) + base.rotation * by).into();
    }
    // With one tool for both it is another arm.
    let shared = unify(&of.robot, &of.data, &of.names, SessionRules::default()).unwrap_err().to_string();
    assert!(shared.contains("session S1") && shared.contains("tool"), "{shared}");
    let (unified, own) = fitted(&of, SessionRules { tool: true, ..SessionRules::default() });
    assert!(unified.remarks.iter().any(|remark| remark.contains("is turned")), "{:?}", unified.remarks);
    let mut part = of.data.select(&(120..of.data.len()).collect::<Vec<_>>());
    part.set_sessions(None);
    for target in part.target.iter_mut().flatten() {
        *target = own.target_in_session(*target, 1);
    }
    let rms = Residuals::of(&own.in_session(1).unwrap(), &part).unwrap().positions().rms;
    // The base by which the record was moved is that of a placement without errors: off by a part of a milliradian.
    assert!(rms < 2e-4, "{rms}");
}
