//! The model and the plant, both against digits that a third program wrote down (`digits.py`).

use truepose_kinematics::nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Chain, Conditions, Load, Payload, Pose, PostureBuffer, samples};
use truepose_simulate::Plant;

struct Record {
    robot: Chain,
    conditions: Conditions,
    pose: Pose,
    loads: Vec<f64>,
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

fn records() -> Vec<Record> {
    let text = include_str!("digits.json");
    let all: serde_json::Value = serde_json::from_str(text).expect("JSON");
    let record = |value: &serde_json::Value| {
        let (robot, mass, com) = match value["robot"].as_str() {
            Some("ur10") => (samples::ur10(), 7.5, [0.02, -0.03, 0.12]),
            Some("heavy") => (samples::heavy(), 90.0, [0.1, -0.05, 0.3]),
            _ => (samples::skewed(), 4.0, [0.1, 0.0, -0.05]),
        };
        let load = Load::Payload(Payload { mass, com: com.into() });
        let conditions = Conditions::at(&robot, &numbers(&value["joints"])).with_load(load);
        let rows: Vec<f64> = value["rotation"].as_array().expect("rows").iter().flat_map(numbers).collect();
        let position = numbers(&value["position"]);
        Record {
            robot,
            conditions,
            pose: Pose::new(Matrix3::from_row_slice(&rows), Vector3::from_column_slice(&position)),
            loads: numbers(&value["loads"]),
        }
    };
    all.as_array().expect("a list").iter().map(record).collect()
}

/// A femtometre and a tenth of a nanonewton metre: round-off of some ten products of numbers near one, and
/// of sums of torques near a thousand.
#[track_caller]
fn check(who: &str, record: &Record, pose: &Pose, loads: &[f64]) {
    let name = record.robot.name();
    assert!((pose.rotation - record.pose.rotation).amax() < 2e-15, "{who}, {name}: rotation");
    assert!((pose.translation - record.pose.translation).amax() < 4e-15, "{who}, {name}: position");
    assert_eq!(loads.len(), record.loads.len(), "{who}, {name}");
    for (got, expected) in loads.iter().zip(&record.loads) {
        assert!((got - expected).abs() < 1e-11, "{who}, {name}: load {got} against {expected}");
    }
}

#[test]
fn the_model_agrees_with_the_recorded_digits() {
    for record in records() {
        let mut buffer = PostureBuffer::new(&record.robot);
        let posture = buffer.update(&record.robot, &record.conditions);
        let loads: Vec<f64> = record.robot.movable().iter().map(|&j| posture.joint_load(j)).collect();
        check("posture", &record, posture.tool(), &loads);
        check("forward", &record, &record.robot.forward(&record.conditions.joints), &loads);
    }
}

#[test]
fn the_plant_agrees_with_the_recorded_digits() {
    for record in records() {
        let plant = Plant::perfect(&record.robot).expect("a plant");
        let pose = plant.true_pose(&record.conditions).expect("a pose");
        let loads = plant.joint_loads(&record.conditions).expect("loads");
        check("plant", &record, &pose, &loads);
    }
}
