//! `truepose map`: accuracy over the workspace, before and after compensation.

use super::{beyond, print_json, status, target};
use crate::args::Map;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use truepose_compensate::{AccuracyMap, MapGrid, MapOptions, Status, accuracy_map, middle_conditions};
use truepose_errormodel::{EffectRegistry, FittedModel};
use truepose_io::{MapRow, check_writable, read_fit, write_map};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Load, Payload, Pose};
use truepose_report::{count, millimetres};

/// Runs the verb.
pub fn run(args: &Map, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let fitted = read_fit(&args.fit, &EffectRegistry::builtin())?.of_robot();
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
    if args.rpy.is_some() {
        terminal::warn(
            beyond::oriented(&fitted).map_err(|words| Failure::Input(format!("--rpy: {words}")))?.as_slice(),
        );
    }
    let options = MapOptions { grid, conditions, target: target(&fitted, args.target.as_deref())? };
    let seen = beyond::seen(&fitted, options.target);
    terminal::warn(
        seen.map_err(|words| Failure::Input(format!("{}: {words}", args.fit.display())))?.as_slice(),
    );
    watch.doing("mapping");
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
            extrapolates: node.extrapolates(),
            beyond: beyond::words(&node.beyond, chain, &fitted.channels),
        })
        .collect();
    write_map(&args.out, chain, &rows)?;
    say(args, &fitted, &map)
}

fn say(args: &Map, fitted: &FittedModel, map: &AccuracyMap) -> Result<(), Failure> {
    let mut tally = beyond::Tally::default();
    let reached = map.nodes.iter().filter(|node| node.status == Status::Ok);
    reached.clone().for_each(|node| tally.add(&node.beyond));
    tally.warn("place", fitted.chain(), &fitted.channels);
    let not_helped = reached.filter(|node| !node.helps).count();
    let within = map.within();
    let figures = |map: &AccuracyMap| {
        serde_json::json!({
            "places": map.nodes.len(),
            "before": {"rms_mm": 1e3 * map.before_rms(), "max_mm": 1e3 * map.before_max()},
            "after_95": {"rms_mm": 1e3 * map.after_95_rms(), "max_mm": 1e3 * map.after_95_max()},
        })
    };
    if args.json {
        let mut json = figures(map);
        json["reachable"] = map.reachable().into();
        json["extrapolating"] = tally.beyond().into();
        json["not_helped"] = not_helped.into();
        json["within"] = figures(&within);
        return print_json(&json);
    }
    let reached = (map.reachable() * map.nodes.len() as f64).round().max(1.0);
    terminal::print(&format!(
        "{}, {:.0} % of them reachable; written to {}\n",
        count(map.nodes.len(), "place"),
        100.0 * map.reachable(),
        args.out.display()
    ));
    if map.reachable() > 0.0 {
        terminal::print(&format!(
            "{} of the reachable places ({:.0} %) are within the range of the data of the fit\n",
            within.nodes.len(),
            100.0 * within.nodes.len() as f64 / reached
        ));
    }
    let print = |map: &AccuracyMap, where_: &str| {
        terminal::print(&format!(
            "{where_}before compensation: RMS {}, max {}\n{where_}after compensation (95 % bound of each place): RMS {}, max {}\n",
            millimetres(map.before_rms()),
            millimetres(map.before_max()),
            millimetres(map.after_95_rms()),
            millimetres(map.after_95_max()),
        ));
    };
    if !within.nodes.is_empty() {
        print(&within, "");
    }
    if tally.beyond() > 0 {
        print(map, "including extrapolated places (not verified by data): ");
    }
    if not_helped > 0 {
        terminal::print(&format!(
            "{} where the correction is smaller than its uncertainty: the nominal command is equally accurate there\n",
            count(not_helped, "place")
        ));
    }
    Ok(())
}
