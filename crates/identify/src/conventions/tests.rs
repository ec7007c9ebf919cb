//! Each mistake of convention is named on data of a robot that was described with it.

use super::*;
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::FRAC_PI_2;
use truepose_errormodel::{DatasetBuilder, Measurement};
use truepose_kinematics::{Joint, JointKind, Placed, Pose, rotation_vector};

use truepose_kinematics::Placement as Form;

/// An arm of six joints with elbow and wrist offsets, m and rad: neither symmetric nor of a simple wrist.
fn arm(form: fn([f64; 4]) -> Form) -> Chain {
    let rows = [
        [0.0, 0.40, 0.15, -FRAC_PI_2],
        [-FRAC_PI_2, 0.0, 0.60, 0.0],
        [0.0, 0.02, 0.12, -FRAC_PI_2],
        [0.0, 0.62, 0.0, FRAC_PI_2],
        [0.0, 0.0, 0.03, -FRAC_PI_2],
        [0.0, 0.10, 0.0, 0.0],
    ];
    let joint =
        |(k, row): (usize, [f64; 4])| Joint::new(format!("j{}", k + 1), JointKind::Revolute, form(row));
    let open = Placed { known: false, ..Placed::default() };
    Chain::new("arm", rows.into_iter().enumerate().map(joint).collect()).unwrap().with_tool(open).unwrap()
}

fn dh([theta, d, a, alpha]: [f64; 4]) -> Form {
    Form::Dh { theta, d, a, alpha }
}

fn mdh([theta, d, a, alpha]: [f64; 4]) -> Form {
    Form::Mdh { alpha, a, theta, d }
}

/// Measurements of this robot with noise of 0.05 mm, from a base 3 m away, of a point off the flange; joints and orientations pass through
/// what was done to them.
fn measured(truth: &Chain, joints: fn(&mut [f64]), read: fn(&Matrix3<f64>) -> Matrix3<f64>) -> Dataset {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let base = Pose::from_xyz_rpy([2.0, -1.0, 2.0], [0.3, -0.2, 2.0]);
    let tool = Pose::from_xyz_rpy([0.05, 0.02, 0.11], [0.1, 0.9, -0.4]);
    let mut builder = DatasetBuilder::new(truth);
    for visit in 0..60 {
        let mut q: Vec<f64> = (0..6).map(|_| rng.random_range(-1.4..1.4)).collect();
        let pose = base * truth.forward(&q) * tool;
        let noise = Vector3::from_fn(|_, _| rng.random_range(-1e-4..1e-4));
        joints(&mut q);
        let orientation = Pose::new(read(&pose.rotation), Vector3::zeros()).quaternion();
        let row = Measurement::at(q).visit(visit).position(pose.translation + noise).orientation(orientation);
        builder.push(row).unwrap();
    }
    builder.finish()
}

fn same(_: &mut [f64]) {}

fn named(described: &Chain, data: &Dataset) -> (f64, Vec<Misreading>) {
    let found = nominal_residual(described, data).unwrap().unwrap();
    (found.share(), misreadings(described, data, &found).into_iter().map(|m| m.what).collect())
}

#[test]
fn a_right_description_leaves_the_noise() {
    let truth = arm(dh);
    let data = measured(&truth, same, |r| *r);
    let found = nominal_residual(&truth, &data).unwrap().unwrap();
    // The noise is uniform: 0.1 mm / √3 in each of three directions.
    assert!((5e-5..1.2e-4).contains(&found.position_rms), "{}", found.position_rms);
    assert!(found.orientation_rms.unwrap() < 1e-3);
    assert_eq!(misreadings(&truth, &data, &found), []);
}

#[test]
fn mistakes_in_the_description() {
    for (truth, described, expected) in
        [(arm(dh), arm(mdh), Misreading::MdhForDh), (arm(mdh), arm(dh), Misreading::DhForMdh)]
    {
        let (share, found) = named(&described, &measured(&truth, same, |r| *r));
        assert!(share > 0.01, "{share}");
        assert_eq!(found, [expected]);
    }
    let truth = arm(dh);
    let data = measured(&truth, same, |r| *r);
    let degrees = 180.0 / std::f64::consts::PI;
    for undo in [
        Misreading::AngleUnit { factor: 1.0 / degrees },
        Misreading::Sign { joint: Some(1), parameter: "a" },
        Misreading::Sign { joint: Some(0), parameter: "alpha" },
        Misreading::Sign { joint: Some(3), parameter: "d" },
    ] {
        let wrong = match undo {
            Misreading::AngleUnit { .. } => {
                variants::undone(&Misreading::AngleUnit { factor: degrees }, &truth)
            }
            ref sign => variants::undone(sign, &truth),
        };
        let (share, found) = named(&wrong.unwrap(), &data);
        assert!(share > 0.01, "{undo:?} {share}");
        assert_eq!(found, [undo]);
    }
    let wrong =
        variants::undone(&Misreading::Length { joint: 1, parameter: "a", change: 0.045 }, &truth).unwrap();
    let (share, found) = named(&wrong, &data);
    let [Misreading::Length { joint: 1, parameter: "a", change }] = found[..] else { panic!("{found:?}") };
    assert!((change + 0.045).abs() < 5e-4 && share > 0.005, "{change} {share}");
}

#[test]
fn coupled_joints() {
    let truth = arm(dh);
    let data = measured(&truth, |q| q[2] -= q[1], |r| *r);
    let (share, found) = named(&truth, &data);
    assert!(share > 0.01);
    assert_eq!(found, [Misreading::Coupling { joint: 2, driver: 1, sign: 1.0 }]);
}

#[test]
fn conventions_of_orientations() {
    let truth = arm(dh);
    let as_vector: fn(&Matrix3<f64>) -> Matrix3<f64> =
        |r| rotation_vector(&Vector3::from(Pose::new(*r, Vector3::zeros()).rpy()));
    let (share, found) = named(&truth, &measured(&truth, same, as_vector));
    assert!(share < 1e-3);
    assert_eq!(found, [Misreading::Angles { convention: "rpy" }]);
    let (_, found) = named(&truth, &measured(&truth, same, Matrix3::transpose));
    assert_eq!(found, [Misreading::InverseOrientation]);
    let (_, found) = named(
        &truth,
        &measured(&truth, same, |r| {
            let [w, x, y, z] = Pose::new(*r, Vector3::zeros()).quaternion();
            Pose::rotation_from_quaternion([x, y, z, w])
        }),
    );
    assert_eq!(found, [Misreading::ScalarLast]);
}

#[test]
fn rotation_vectors_as_angles_and_inverse_poses() {
    let truth = arm(dh);
    let as_angles: fn(&Matrix3<f64>) -> Matrix3<f64> = |r| {
        let [a, b, c]: [f64; 3] = truepose_kinematics::rotation_log(r).into();
        Pose::from_xyz_rpy([0.0; 3], [a, b, c]).rotation
    };
    let (share, found) = named(&truth, &measured(&truth, same, as_angles));
    assert!(share < 1e-3);
    assert_eq!(found, [Misreading::RotationVector]);
    let mut data = measured(&truth, same, |r| *r);
    variants::undo_rows(&Misreading::InversePoses, &mut data);
    let (share, found) = named(&truth, &data);
    assert!(share > 0.01);
    assert_eq!(found, [Misreading::InversePoses]);
}

#[test]
fn a_declared_tool_that_is_elsewhere() {
    let truth = arm(dh);
    let data = measured(&truth, same, |r| *r);
    let with = |xyz: [f64; 3]| {
        let tool = Placed { pose: Pose::from_xyz_rpy(xyz, [0.1, 0.9, -0.4]), known: true };
        named(&truth.clone().with_tool(tool).unwrap(), &data).1
    };
    // As in `measured`; signs, turns by a quarter about z, and something else.
    assert_eq!(with([0.05, 0.02, 0.11]), []);
    assert_eq!(with([0.05, 0.02, -0.11]), [Misreading::ToolSign { axis: 2 }]);
    let [Misreading::ToolTurned { axis: 2, angle }] = with([-0.02, 0.05, 0.11])[..] else { panic!("a turn") };
    assert!((angle + FRAC_PI_2).abs() < 1e-12);
    assert_eq!(with([0.0, 0.08, 0.2]), [Misreading::ToolElsewhere]);
}
