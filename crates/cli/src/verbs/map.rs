//! `truepose map`: accuracy over the workspace, before and after compensation.

use super::reporting::Folder;
use super::{print_json, status, target, usable_fit};
use crate::args::Map;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use std::path::Path;
use truepose_compensate::{
    AccuracyMap, MapGrid, MapNode, MapOptions, Status, accuracy_map, middle_conditions,
};
use truepose_errormodel::FittedModel;
use truepose_io::{MapRow, WholeFiles, check_writable, map_file};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Load, Payload, Pose};
use truepose_report::{MapView, PlaceView, count, map_report, millimetres};
use truepose_workflow::{beyond, in_session};

/// Runs the verb.
pub fn run(args: &Map, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let folder = Folder::with_head(args.report.as_ref(), "map.json", args.certificate.as_ref())?;
    let fitted = in_session(usable_fit(&args.fit, &args.accept)?, args.session.as_deref(), true)?.of_robot();
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
            before_95: node.before_95,
            after_95: node.after_95,
            extrapolates: node.extrapolates(),
            beyond: beyond::words(&node.beyond, chain, &fitted.channels),
        })
        .collect();
    let mut files = WholeFiles::default();
    files.push(map_file(&args.out, chain, &rows)?)?;
    if let Some(folder) = &folder {
        let view = MapView {
            robot: chain.name().into(),
            sentences: sentences(&map),
            places: map.nodes.iter().map(place).collect(),
        };
        let inputs: Vec<&Path> =
            [Some(&args.fit), args.certificate.as_ref()].into_iter().flatten().map(|file| &**file).collect();
        folder.add(&mut files, &view, &inputs, |run| Ok(map_report(&view, run)))?;
    }
    files.finish()?;
    if let Some(folder) = &folder {
        terminal::log(&format!("wrote {}", folder.page().display()));
    }
    say(args, &fitted, &map)
}

/// A node as the page and JSON have it.
fn place(node: &MapNode) -> PlaceView {
    let reached = node.status == Status::Ok;
    let mm = |v: f64| reached.then_some(1e3 * v);
    PlaceView {
        at_mm: (1e3 * node.position).into(),
        status: status(node.status).word().into(),
        before_mm: mm(node.before),
        before_95_mm: mm(node.before_95),
        after_95_mm: mm(node.after_95),
        extrapolates: reached.then(|| node.extrapolates()),
    }
}

/// What the map shows, a sentence a line: for the terminal and the page.
fn sentences(map: &AccuracyMap) -> Vec<String> {
    let reached = (map.reachable() * map.nodes.len() as f64).round().max(1.0);
    let within = map.within();
    let mut lines = vec![format!(
        "{}, {:.0} % of them reachable",
        count(map.nodes.len(), "place"),
        100.0 * map.reachable()
    )];
    if map.reachable() > 0.0 {
        lines.push(format!(
            "{} of the reachable places ({:.0} %) are within the range of the data of the fit",
            within.nodes.len(),
            100.0 * within.nodes.len() as f64 / reached
        ));
    }
    let bounds = |map: &AccuracyMap, where_: &str| {
        [
            ("before", map.before_95_rms(), map.before_95_max()),
            ("after", map.after_95_rms(), map.after_95_max()),
        ]
        .map(|(when, rms, max)| {
            format!(
                "{where_}{when} compensation (95 % bound of each place): RMS {}, max {}",
                millimetres(rms),
                millimetres(max)
            )
        })
    };
    if !within.nodes.is_empty() {
        lines.extend(bounds(&within, ""));
    }
    if map.nodes.iter().any(|node| node.status == Status::Ok && node.extrapolates()) {
        lines.extend(bounds(map, "including extrapolated places (not verified by data): "));
    }
    lines
}

fn say(args: &Map, fitted: &FittedModel, map: &AccuracyMap) -> Result<(), Failure> {
    let mut tally = beyond::Tally::default();
    let reached = map.nodes.iter().filter(|node| node.status == Status::Ok);
    reached.clone().for_each(|node| tally.add(&node.beyond));
    terminal::warn(tally.warning("place", fitted.chain(), &fitted.channels).as_slice());
    let not_helped = reached.filter(|node| !node.helps).count();
    let within = map.within();
    let figures = |map: &AccuracyMap| {
        // Of no place there is no error.
        let of = |rms: f64, max: f64| {
            let any = map.reachable() > 0.0;
            serde_json::json!({"rms_mm": any.then_some(1e3 * rms), "max_mm": any.then_some(1e3 * max)})
        };
        serde_json::json!({
            "places": map.nodes.len(),
            "before": of(map.before_rms(), map.before_max()),
            "before_95": of(map.before_95_rms(), map.before_95_max()),
            "after_95": of(map.after_95_rms(), map.after_95_max()),
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
    let lines = sentences(map);
    terminal::print(&format!("{}; written to {}\n", lines[0], args.out.display()));
    for line in &lines[1..] {
        terminal::print(&format!("{line}\n"));
    }
    if not_helped > 0 {
        terminal::print(&format!(
            "{} where the correction is smaller than its uncertainty: the nominal command is equally accurate there\n",
            count(not_helped, "place")
        ));
    }
    Ok(())
}
