//! The robot elsewhere, or seen from another frame: base and measured positions move together.

use super::case::Case;
use toml::Value;
use truepose_kinematics::nalgebra::{Isometry3, Point3, Rotation3, Translation3, Vector3};

/// One of the units of lengths or angles, SI.
pub fn si(unit: &str) -> f64 {
    match unit {
        "mm" => 1e-3,
        "um" => 1e-6,
        "in" => 25.4e-3,
        "deg" => 1f64.to_radians(),
        "mrad" => 1e-3,
        _ => 1.0,
    }
}

/// Gravity in the measurement frame, m/s².
pub fn gravity(case: &Case) -> Vector3<f64> {
    case.robot.get("gravity").map_or(Vector3::new(0.0, 0.0, -9.81), |value| vector(Some(value)))
}

fn vector(value: Option<&Value>) -> Vector3<f64> {
    let number = |value: &Value| value.as_float().or_else(|| Some(value.as_integer()? as f64)).unwrap();
    match value.and_then(Value::as_array) {
        Some(list) => Vector3::from_iterator(list.iter().map(number)),
        None => Vector3::zeros(),
    }
}

fn list(vector: &Vector3<f64>) -> Value {
    Value::Array(vector.iter().map(|&v| Value::Float(v)).collect())
}

/// Moves base and measured positions by `motion`, in the measurement frame.
pub fn moved(case: &mut Case, motion: &Isometry3<f64>) {
    let columns = ["x", "y", "z"].map(|axis| case.column(axis).unwrap());
    let length = si(case.columns[columns[0]].1.as_deref().unwrap());
    for row in &mut case.rows {
        let at = columns.map(|k| row[k].parse::<f64>().unwrap() * length);
        let to = motion * Point3::from(at) / length;
        columns.iter().zip(to.iter()).for_each(|(&k, v)| row[k] = format!("{v:.8}"));
    }
    let (length, angle) = (si(&case.unit("length")), si(&case.unit("angle")));
    let base = case.robot.entry("base").or_insert_with(|| Value::Table(toml::Table::new()));
    let base = base.as_table_mut().unwrap();
    let (xyz, rpy) = (vector(base.get("xyz")) * length, vector(base.get("rpy")) * angle);
    let turned = Rotation3::from_euler_angles(rpy.x, rpy.y, rpy.z);
    let whole = motion * Isometry3::from_parts(Translation3::from(xyz), turned.into());
    let (roll, pitch, yaw) = whole.rotation.euler_angles();
    base.insert("xyz".into(), list(&(whole.translation.vector / length)));
    base.insert("rpy".into(), list(&(Vector3::new(roll, pitch, yaw) / angle)));
}

/// Turns the measurement frame, and gravity with it.
pub fn turned(case: &mut Case, by: &Rotation3<f64>) {
    let gravity = by * gravity(case);
    moved(case, &Isometry3::from_parts(Translation3::identity(), (*by).into()));
    case.robot.insert("gravity".into(), list(&gravity));
}
