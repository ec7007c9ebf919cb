//! The peers' robots and tables as ours: same chain, same errors behind each joint, same loads.

use crate::table::Table;
use crate::workload::Failure;
use serde_json::Value;
use std::path::Path;
use truepose_errormodel::{Dataset, Schema};
use truepose_kinematics::nalgebra::{Matrix3, Unit, Vector3};
use truepose_kinematics::{
    Chain, Gravity, GravityFrame, Joint, JointKind, Link, Load, Payload, Placed, Placement, Pose, Target,
    TargetId, Wrench,
};

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        other => other.as_f64().into_iter().collect(),
    }
}

fn vector(value: &Value) -> Result<Vector3<f64>, Failure> {
    match numbers(value)[..] {
        [x, y, z] => Ok(Vector3::new(x, y, z)),
        _ => Err("a vector has three numbers".into()),
    }
}

fn rotation(value: &Value) -> Result<Matrix3<f64>, Failure> {
    let list = numbers(value);
    if list.len() != 9 {
        return Err("a rotation has nine numbers".into());
    }
    Ok(Matrix3::from_row_slice(&list))
}

/// `pps.json` or `arm6r.json`.
pub fn robot(path: &Path) -> Result<Chain, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let all: Value = serde_json::from_str(&text)?;
    let mut joints = Vec::new();
    for joint in all["joints"].as_array().ok_or("a robot has joints")? {
        let kind = if joint["type"] == "P" { JointKind::Prismatic } else { JointKind::Revolute };
        let axis = match joint["axis"].as_str() {
            Some("x") => Vector3::x(),
            Some("y") => Vector3::y(),
            _ => Vector3::z(),
        };
        let pose = Pose::new(rotation(&joint["R"])?, vector(&joint["xyz"])?);
        let name = joint["name"].as_str().unwrap_or_default();
        let placement = Placement::Origin { pose, axis: Unit::new_normalize(axis) };
        let mut made = Joint::new(name, kind, placement);
        made.limits = joint["lo"].as_f64().zip(joint["hi"].as_f64());
        made.link = Some(Link { mass: joint["mass"].as_f64().unwrap_or(0.0), com: vector(&joint["com"])? });
        joints.push(made);
    }
    let tool = Pose::new(rotation(&all["tool_R"])?, vector(&all["tool_xyz"])?);
    let mut targets = Vec::new();
    for (k, position) in all["targets"].as_array().into_iter().flatten().enumerate() {
        targets.push(Target {
            name: format!("P{}", k + 1),
            position: vector(position)?,
            known: true,
            tool: truepose_kinematics::ToolId::FIRST,
        });
    }
    let gravity = Gravity { vector: Vector3::new(0.0, 0.0, -9.80665), frame: GravityFrame::Measurement };
    let chain = Chain::new(all["name"].as_str().unwrap_or("robot"), joints)?;
    Ok(chain.with_tool(Placed { pose: tool, known: true })?.with_targets(targets)?.with_gravity(gravity)?)
}

/// All rows of a table of the peers' data for a robot with six joints.
pub fn rows_of(folder: &Path, file: &str) -> Result<Dataset, Failure> {
    dataset(&Table::read(&folder.join(file))?, 6, |_| true)
}

/// The rows of a table for which `used` says so, of so many joints.
pub fn dataset(table: &Table, joints: usize, used: impl Fn(usize) -> bool) -> Result<Dataset, Failure> {
    let rows: Vec<usize> = (0..table.rows()).filter(|&row| used(row)).collect();
    let pick = |column: &[f64]| rows.iter().map(|&row| column[row]).collect::<Vec<f64>>();
    let named = |name: &str| table.column(name).map(pick);
    let count = rows.len();
    let place = if table.has("mx") { ["mx", "my", "mz"] } else { ["x", "y", "z"] };
    let position = match table.has(place[0]) {
        true => {
            let [x, y, z] = [named(place[0])?, named(place[1])?, named(place[2])?];
            (0..count).map(|k| [x[k], y[k], z[k]]).collect()
        }
        false => vec![[f64::NAN; 3]; count],
    };
    let orientation = match table.has("qw") {
        true => {
            let [w, x, y, z] = [named("qw")?, named("qx")?, named("qy")?, named("qz")?];
            (0..count).map(|k| Some([w[k], x[k], y[k], z[k]])).collect()
        }
        false => vec![None; count],
    };
    let target = match table.has("target") {
        true => named("target")?.iter().map(|&t| Some(TargetId(t as usize))).collect(),
        false => vec![None; count],
    };
    // The peers' w is the load that the elastic terms are functions of: here a force, one component of a measured wrench.
    let load = if table.has("w") {
        let force = |w: &f64| Wrench { force: Vector3::new(0.0, *w, 0.0), moment: Vector3::zeros() };
        named("w")?.iter().map(|w| Load::Wrench(force(w))).collect()
    } else if table.has("payload") {
        let payload = |mass: &f64| Load::Payload(Payload { mass: *mass, com: Vector3::zeros() });
        named("payload")?.iter().map(payload).collect()
    } else {
        vec![Load::None; count]
    };
    let visit = match table.has("config") {
        true => {
            let configuration = named("config")?;
            let mut visit = Vec::with_capacity(count);
            for k in 0..count {
                let last = visit.last().copied();
                let same = k > 0 && configuration[k].to_bits() == configuration[k - 1].to_bits();
                visit.push(match last {
                    Some(v) if same => v,
                    Some(v) => v + 1,
                    None => 0,
                });
            }
            visit
        }
        false => (0..count).collect(),
    };
    Ok(Dataset {
        schema: Schema { load: true, ..Schema::default() },
        joints: table.series("q", 1..joints + 1)?.iter().map(|column| pick(column)).collect(),
        position,
        orientation,
        position_sd: vec![[f64::NAN; 3]; count],
        orientation_sd: vec![[f64::NAN; 3]; count],
        target,
        visit,
        load,
        time: vec![0.0; count],
        approach: vec![vec![0.0; count]; joints],
        ..Dataset::default()
    })
}
