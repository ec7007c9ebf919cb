//! Robots that nobody draws on a slide: each is identified to its noise, predicted, and brought to where it should be, or
//! the answer says why not. Truth is a model with known errors, so that what is left is noise and nothing else.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_compensate::{Compensator, CompensatorOptions, Status, Target};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, FittedModel, Schema};
use truepose_identify::{IdentificationOptions, Residuals, identify};
use truepose_kinematics::nalgebra::{DMatrix, Unit, Vector3};
use truepose_kinematics::{Chain, Conditions, Joint, JointKind, Load, Placed, Placement, Pose};
use truepose_solvers::PivotedQr;

const TURN: JointKind = JointKind::Revolute;
const SLIDE: JointKind = JointKind::Prismatic;

/// A joint at a place seen from the one before, about or along an axis; ± 2 rad or ± 40 % of `size`.
fn joint(number: usize, kind: JointKind, xyz: [f64; 3], axis: [f64; 3], size: f64) -> Joint {
    let pose = Pose::from_xyz_rpy(xyz.map(|v| v * size), [0.0; 3]);
    let axis = Unit::new_normalize(Vector3::from(axis));
    let reach = if kind == SLIDE { 0.4 * size } else { 2.0 };
    Joint::new(format!("q{number}"), kind, Placement::Origin { pose, axis }).with_limits(-reach, reach)
}

/// What a test is about, and the robot, whose tool is a fifth of its size away from the last joint.
fn robots() -> Vec<(String, Chain, f64)> {
    let mut list = Vec::new();
    let mut add = |what: &str, joints: Vec<Joint>, size: f64| {
        let tool = Pose::from_xyz_rpy([0.12 * size, 0.05 * size, 0.16 * size], [0.0; 3]);
        let chain = Chain::new(what, joints).unwrap().with_tool(Placed { pose: tool, known: true }).unwrap();
        list.push((what.to_owned(), chain, size));
    };
    let axes = [
        [0.0, 0.0, 1.0],
        [0.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
    ];
    let steps = [
        [0.0, 0.0, 0.3],
        [0.1, 0.0, 0.1],
        [0.0, 0.0, 0.5],
        [0.1, 0.02, 0.1],
        [0.4, 0.0, 0.0],
        [0.1, 0.0, 0.0],
    ];
    let arm = |n: usize, size: f64| -> Vec<Joint> {
        (0..n).map(|k| joint(k + 1, TURN, steps[k % 6], axes[k % 6], size)).collect()
    };
    for n in 1..=12 {
        add(&format!("{n} joints"), arm(n, 1.0), 1.0);
    }
    add("of a millimetre", arm(6, 1e-3), 1e-3);
    add("of a kilometre", arm(6, 1e3), 1e3);
    add("a single slide", vec![joint(1, SLIDE, [0.0; 3], [1.0, 2.0, 2.0], 1.0)], 1.0);
    add(
        "three slides",
        (0..3)
            .map(|k| joint(k + 1, SLIDE, [0.1; 3], std::array::from_fn(|i| f64::from(u8::from(i == k))), 1.0))
            .collect(),
        1.0,
    );
    add(
        "parallel axes",
        (0..4).map(|k| joint(k + 1, TURN, [0.3, 0.0, 0.05], [0.0, 0.0, 1.0], 1.0)).collect(),
        1.0,
    );
    let coincident = (0..6).map(|k| joint(k + 1, TURN, [0.0; 3], axes[k], 1.0)).collect();
    add("all joints in one point", coincident, 1.0);
    add(
        "all axes in one line",
        (0..3).map(|k| joint(k + 1, TURN, [0.0; 3], [0.0, 0.0, 1.0], 1.0)).collect(),
        1.0,
    );
    let mut wrist = arm(3, 1.0);
    wrist.extend(
        (3..6).map(|k| joint(k + 1, TURN, if k == 3 { [0.5, 0.0, 0.0] } else { [0.0; 3] }, axes[k], 1.0)),
    );
    add("a spherical wrist", wrist, 1.0);
    let mut backwards = arm(6, 1.0);
    for joint in &mut backwards {
        if let Placement::Origin { axis, .. } = &mut joint.placement {
            *axis = -*axis;
        }
    }
    add("negative axes", backwards, 1.0);
    let mut rail: Vec<Joint> = (0..3)
        .map(|k| {
            joint(k + 1, SLIDE, [0.0, 0.0, 0.2], std::array::from_fn(|i| f64::from(u8::from(i == k))), 2.0)
        })
        .collect();
    rail.extend((0..6).map(|k| joint(k + 4, TURN, steps[k], axes[k], 1.0)));
    add("a gantry with an arm: nine axes", rail, 1.0);
    list
}

/// The robot with errors of a thousandth of its size.
fn real(chain: &Chain, size: f64, rng: &mut ChaCha8Rng) -> FittedModel {
    let effects: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let model = ErrorModel::new(chain.clone(), effects).unwrap();
    let scale = |unit: &str| if unit == "m" { 1e-3 * size } else { 1e-3 };
    let truth =
        model.columns().iter().map(|column| scale(&column.unit) * rng.random_range(-1.0..1.0)).collect();
    let n = model.columns().len();
    FittedModel::new(model, truth, DMatrix::zeros(n, n)).unwrap()
}

/// Visits with noise of this size, m; orientations are seen without any.
fn measured(truth: &FittedModel, visits: usize, noise: f64, rng: &mut ChaCha8Rng) -> Dataset {
    let chain = truth.chain();
    let n = chain.movable().len();
    let mut data =
        Dataset { joints: vec![Vec::new(); n], approach: vec![vec![0.0; visits]; n], ..Dataset::default() };
    let mut predictor = truth.bind(&data.schema).unwrap();
    for visit in 0..visits {
        let joints: Vec<f64> = chain
            .movable()
            .iter()
            .map(|&j| {
                let (lower, upper) = chain.joint(j).limits.unwrap();
                rng.random_range(lower..upper)
            })
            .collect();
        let pose = predictor.predict(&Conditions::at(chain, &joints), None);
        let error = Vector3::from_fn(|_, _| noise * 1.7 * rng.random_range(-1.0..1.0));
        data.joints.iter_mut().zip(&joints).for_each(|(column, &q)| column.push(q));
        data.position.push((pose.translation + error).into());
        data.orientation.push(None);
        data.position_sd.push([f64::NAN; 3]);
        data.orientation_sd.push([f64::NAN; 3]);
        data.target.push(None);
        data.visit.push(visit);
        data.load.push(Load::None);
        data.time.push(0.0);
    }
    data
}

#[test]
fn odd_robots_are_identified_predicted_and_compensated() {
    for (seed, (what, chain, size)) in (0..).zip(robots()) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let truth = real(&chain, size, &mut rng);
        let noise = 2e-5 * size;
        let data = measured(&truth, 120, noise, &mut rng);
        let effects: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
        let options = IdentificationOptions::default();
        let found = identify(&chain, &effects, &data, &PivotedQr::default(), &options, &|_| ())
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        // Three axes of noise, and what the coefficients leave open on rows that were not seen.
        let floor = 3f64.sqrt() * noise;
        let fitted = &found.fit.fitted;
        let fresh = measured(&truth, 80, 0.0, &mut rng);
        let left = Residuals::of(fitted, &fresh).unwrap().positions().rms;
        let held_out = found.declared.held_out.as_ref().unwrap().residuals.positions().rms;
        assert!(held_out < 1.4 * floor, "{what}: held out {held_out:e} m, noise {floor:e} m");
        assert!(left < floor, "{what}: {left:e} m on new visits, noise {floor:e} m");

        let mut compensator =
            Compensator::bind(fitted, &Schema::default(), CompensatorOptions::default()).unwrap();
        let mut predictor = truth.bind(&Schema::default()).unwrap();
        let mut reached = 0;
        for row in 0..fresh.len() {
            let position = fresh.measured_position(row);
            let seed: Vec<f64> = fresh.joints.iter().map(|column| column[row]).collect();
            let command =
                compensator.command(&Target::at(position), &Conditions::at(&chain, &seed), Some(&seed));
            assert!(command.joints.iter().all(|q| q.is_finite()), "{what}: {command:?}");
            if command.status == Status::Ok {
                let at = predictor.predict(&Conditions::at(&chain, &command.joints), None).translation;
                let miss = (at - position).norm();
                assert!(miss < 5.0 * floor, "{what}: {miss:e} m beside its target");
                reached += 1;
            }
        }
        // With fewer than three joints positions lie on a line or a surface, off which the fitted robot is by its error.
        let free = chain.movable().len() >= 3
            && !what.contains("line")
            && !what.contains("parallel")
            && !what.contains("one point");
        assert!(reached > if free { 60 } else { -1 }, "{what}: only {reached} of 80 are reached");
    }
}
