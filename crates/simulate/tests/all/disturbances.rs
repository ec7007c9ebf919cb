//! What disturbs a campaign has the properties that it claims.

use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Conditions, samples};
use truepose_simulate::{Campaign, Disturbances, Instrument, Plant, StationMotion, Wander};

const POSTURE: [f64; 6] = [0.3, -0.9, 0.8, 0.4, -0.7, 0.2];

fn disturbed(disturbances: Disturbances) -> Plant {
    let mut plant = Plant::perfect(&samples::heavy()).expect("a plant");
    plant.disturbances = disturbances;
    plant
}

#[test]
fn joint_repeatability_has_the_covariance_of_its_jacobian() {
    let sd = [2e-5, 1e-5, 3e-5, 4e-5, 1e-5, 5e-5];
    let plant = disturbed(Disturbances { joint_sd: sd.to_vec(), ..Disturbances::default() });
    let visits = 4000;
    let campaign = Campaign::returns(&POSTURE, visits, 1);
    let seen = plant.observe(&campaign, 3).expect("data");
    let target = seen.data.target[1];
    let place = |joints: &[f64]| {
        plant.true_position(&Conditions::at(plant.chain(), joints), target).expect("a position")
    };
    // J column by column, as differences of the plant's own positions.
    let mut expected = Matrix3::zeros();
    for joint in 0..6 {
        let moved = |step: f64| {
            let mut joints = POSTURE;
            joints[joint] += step;
            place(&joints)
        };
        let column = (moved(1e-5) - moved(-1e-5)) / 2e-5;
        expected += column * column.transpose() * sd[joint] * sd[joint];
    }
    let error = |row: usize| seen.data.measured_position(row) - seen.true_positions[row];
    let mut found = Matrix3::zeros();
    let mut shared = Matrix3::zeros();
    for visit in 0..visits {
        let (a, b) = (error(3 * visit), error(3 * visit + 1));
        found += b * b.transpose() / visits as f64;
        shared += a * b.transpose() / visits as f64;
    }
    // 4000 draws: entries are known to a few per cent of the largest.
    assert!((found - expected).amax() < 0.06 * expected.amax(), "{found} {expected}");
    // The targets of one pose measurement move together.
    assert!(shared.trace() > 0.5 * expected.trace());
    // The record has the command, not where the joint ended.
    assert!(
        seen.data
            .joints
            .iter()
            .zip(POSTURE)
            .all(|(column, q)| column.iter().all(|v| v.to_bits() == q.to_bits()))
    );
}

#[test]
fn recorded_joints_flicker_within_their_amplitude() {
    let flicker = 1e-4f64.to_radians();
    let plant = disturbed(Disturbances { flicker, ..Disturbances::default() });
    let seen = plant.observe(&Campaign::returns(&POSTURE, 500, 1), 3).expect("data");
    let off: Vec<f64> = seen.data.joints[2].iter().map(|q| q - POSTURE[2]).collect();
    let rms = (off.iter().map(|v| v * v).sum::<f64>() / off.len() as f64).sqrt();
    assert!(off.iter().all(|v| v.abs() <= flicker));
    // Uniform: a/√3.
    assert!((rms / (flicker / 3f64.sqrt()) - 1.0).abs() < 0.05, "{rms}");
    // Rows of one pose measurement flicker apart; where the robot is does not change.
    assert!((off[0] - off[1]).abs() > 0.0);
    assert!((seen.data.measured_position(0) - seen.data.measured_position(3)).norm() < 1e-15);
}

#[test]
fn a_wander_is_shared_by_the_targets_and_remembers() {
    let plant = disturbed(Disturbances { wander: Some(Wander::even(0.6, 3e-5)), ..Disturbances::default() });
    let visits = 6000;
    let seen = plant.observe(&Campaign::returns(&POSTURE, visits, 1), 3).expect("data");
    let error: Vec<Vector3<f64>> =
        (0..seen.data.len()).map(|row| seen.data.measured_position(row) - seen.true_positions[row]).collect();
    assert!((error[0] - error[2]).norm() < 1e-15);
    let mean = |lag: usize| {
        let products = (0..visits - lag).map(|k| error[3 * k].dot(&error[3 * (k + lag)]));
        products.sum::<f64>() / (visits - lag) as f64
    };
    assert!((mean(1) / mean(0) - 0.6).abs() < 0.04 && (mean(2) / mean(0) - 0.36).abs() < 0.05);
    assert!(((mean(0) / 3.0).sqrt() / 3e-5 - 1.0).abs() < 0.05);
}

#[test]
fn a_bad_pose_moves_all_its_targets_by_one_amount() {
    let plant = disturbed(Disturbances { bad_poses: 3, bad_size: [5e-4, 2e-3], ..Disturbances::default() });
    let campaign = Campaign::random(plant.chain(), 40, 2).expect("a campaign");
    let seen = plant.observe(&campaign, 7).expect("data");
    assert_eq!(seen.bad_poses.len(), 3);
    for pose in 0..40 {
        let off = |k: usize| seen.data.measured_position(3 * pose + k) - seen.true_positions[3 * pose + k];
        let size = off(0).norm();
        assert!((off(0) - off(2)).norm() < 1e-15);
        assert_eq!(seen.bad_poses.contains(&pose), (5e-4..=2e-3).contains(&size), "{size}");
        assert!(seen.bad_poses.contains(&pose) || size < 1e-15);
    }
}

#[test]
fn stated_deviations_are_wrong_by_their_factor() {
    let mut plant = disturbed(Disturbances { stated_factor: 3.0, ..Disturbances::default() });
    plant.instrument = Instrument { sd: 2e-5, states_sd: true, ..Instrument::default() };
    let seen = plant.observe(&Campaign::returns(&POSTURE, 800, 1), 3).expect("data");
    assert!((seen.data.position_sd[5][1] - 6e-5).abs() < 1e-12);
    let squares = (0..seen.data.len())
        .map(|row| (seen.data.measured_position(row) - seen.true_positions[row]).norm_squared());
    let sd = (squares.sum::<f64>() / (3 * seen.data.len()) as f64).sqrt();
    assert!((sd / 2e-5 - 1.0).abs() < 0.05);
}

#[test]
fn the_station_turns_orientations_with_positions() {
    let station = StationMotion { drift: 1e-4, turn: 5e-5, ..StationMotion::default() };
    let mut plant = disturbed(Disturbances { station: Some(station), ..Disturbances::default() });
    plant.instrument.orientation_sd = Some(0.0);
    plant.instrument.station = Vector3::new(4.0, 0.0, 1.0);
    let campaign = Campaign::random(plant.chain(), 30, 2).expect("a campaign");
    let seen = plant.observe(&campaign, 7).expect("data");
    for row in [0, 44, 89] {
        // Two targets of a pose and the tool's orientation turn by the same small rotation.
        let rotation = seen.data.measured_rotation(row).expect("an orientation");
        let turn = rotation * seen.true_poses[row].rotation.transpose();
        let first = 3 * (row / 3);
        let lever = seen.true_positions[first + 1] - seen.true_positions[first];
        let measured = seen.data.measured_position(first + 1) - seen.data.measured_position(first);
        assert!((turn * lever - measured).norm() < 1e-14);
    }
    let last = seen.data.measured_position(89) - seen.true_positions[89];
    assert!(last.norm() > 1e-6);
}

#[test]
fn one_disturbance_leaves_the_other_noise_as_it_was() {
    let mut quiet = Plant::perfect(&samples::heavy()).expect("a plant");
    quiet.instrument = Instrument { sd: 2e-5, ..Instrument::default() };
    quiet.repeatability.sd = 3e-5;
    let mut loud = quiet.clone();
    loud.disturbances = Disturbances { bad_poses: 1, bad_size: [1e-3, 1e-3], ..Disturbances::default() };
    let campaign = Campaign::random(quiet.chain(), 20, 2).expect("a campaign");
    let (a, b) = (quiet.observe(&campaign, 5).expect("data"), loud.observe(&campaign, 5).expect("data"));
    for row in 0..a.data.len() {
        let same = (a.data.measured_position(row) - b.data.measured_position(row)).norm() < 1e-15;
        assert_eq!(same, !b.bad_poses.contains(&(row / 3)));
    }
}
