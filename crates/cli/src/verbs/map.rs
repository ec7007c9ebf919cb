//! `truepose map`: accuracy over the workspace, before and after compensation.

use super::{print_json, status, target};
use crate::args::Map;
use crate::failure::Failure;
use crate::terminal;
use truepose_compensate::{AccuracyMap, MapGrid, MapOptions, Status, accuracy_map, middle_conditions};
use truepose_errormodel::EffectRegistry;
use truepose_io::{MapRow, check_writable, read_fit, write_map};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Load, Payload, Pose};
use truepose_report::{count, millimetres};

/// Runs the verb.
pub fn run(args: &Map) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let fitted = read_fit(&args.fit, &EffectRegistry::builtin())?;
    let chain = fitted.chain();
    let mut conditions = middle_conditions(&fitted);
    if let Some(mass) = args.payload {
        if !mass.is_finite() || mass < 0.0 {
            return Err(Failure::Input(format!("--payload: {mass} is no mass; it has to be 0 or more")));
        }
        conditions.load = Load::Payload(Payload { mass, com: Vector3::from(args.com.unwrap_or_default()) });
    }
    let points = usize::from(args.points);
    let grid = match (args.from, args.to) {
        (Some(from), Some(to)) => MapGrid::Positions {
            lower: Vector3::from(from).inf(&Vector3::from(to)),
            upper: Vector3::from(from).sup(&Vector3::from(to)),
            points: [points; 3],
            orientation: args.rpy.map(|rpy| Pose::from_xyz_rpy([0.0; 3], rpy.map(f64::to_radians)).rotation),
        },
        _ => MapGrid::Joints { points },
    };
    let options = MapOptions { grid, conditions, target: target(chain, args.target.as_deref())? };
    crate::watch::doing("mapping");
    let map = accuracy_map(&fitted, &options)?;
    let rows: Vec<MapRow> = map
        .nodes
        .iter()
        .map(|node| MapRow {
            position: node.position.into(),
            joints: node.joints.to_vec(),
            status: status(node.status),
            before: node.before,
            after_95: node.after_95,
            extrapolates: node.extrapolates,
        })
        .collect();
    write_map(&args.out, chain, &rows)?;
    say(args, &map)
}

fn say(args: &Map, map: &AccuracyMap) -> Result<(), Failure> {
    let beyond = map.nodes.iter().filter(|node| node.extrapolates && node.status == Status::Ok).count();
    if args.json {
        return print_json(&serde_json::json!({
            "places": map.nodes.len(),
            "reachable": map.reachable(),
            "extrapolating": beyond,
            "before": {"rms_mm": 1e3 * map.before_rms(), "max_mm": 1e3 * map.before_max()},
            "after_95": {"rms_mm": 1e3 * map.after_95_rms(), "max_mm": 1e3 * map.after_95_max()},
        }));
    }
    terminal::print(&format!(
        "{}, {:.0} % of them within reach; written to {}\n",
        count(map.nodes.len(), "place"),
        100.0 * map.reachable(),
        args.out.display()
    ));
    if map.reachable() > 0.0 {
        terminal::print(&format!(
            "before compensation: RMS {}, max {}\nafter it, the 95 % band of a place: RMS {}, largest {}\n",
            millimetres(map.before_rms()),
            millimetres(map.before_max()),
            millimetres(map.after_95_rms()),
            millimetres(map.after_95_max()),
        ));
    }
    if beyond > 0 {
        terminal::print(&format!(
            "{} outside the range that the model was fitted on: it extrapolates there\n",
            count(beyond, "place")
        ));
    }
    Ok(())
}
