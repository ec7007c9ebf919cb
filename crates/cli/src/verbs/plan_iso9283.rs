//! `truepose plan --for iso9283`: the five poses of the standard, in 30 cycles.

use super::{print_json, robot};
use crate::args::{Plan, Robot};
use crate::extensions::effects;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use truepose_acceptance::{TestCube, test_cube};
use truepose_io::{TestPoseRow, check_writable, read_fit, write_test_plan};
use truepose_kinematics::Payload;
use truepose_kinematics::nalgebra::Vector3;
use truepose_report::{count, significant};
use truepose_workflow::in_session;

/// Runs the verb.
pub fn run(args: &Plan, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let chain = match (&args.fit, &args.robot) {
        (Some(file), _) => {
            in_session(read_fit(file, effects())?, args.session.as_deref(), true)?.chain().clone()
        }
        (None, Some(file)) => robot(&Robot {
            robot: file.clone(),
            base: args.base.clone(),
            tip: args.tip.clone(),
            base_known: true,
            tool_known: true,
        })?,
        (None, None) => return Err(Failure::Input("--robot or --fit: one of them is needed".into())),
    };
    let load = match args.loads[..] {
        [] => None,
        [mass] if mass.is_finite() && mass >= 0.0 => {
            Some(Payload { mass, com: Vector3::from_column_slice(&args.com) * 1e-3 })
        }
        _ => return Err(Failure::Input("--loads: one mass of 0 kg or more; a test has one load".into())),
    };
    watch.doing("looking for the largest cube");
    let cube =
        TestCube { edge: args.edge, centre: args.centre, rpy: args.rpy.map(|rpy| rpy.map(f64::to_radians)) };
    let cube =
        test_cube(&chain, &cube).map_err(|error| Failure::Input(format!("{}: {error}", chain.name())))?;
    // P5 to P1 in each cycle, so that every pose is approached from the same one each time.
    let mut rows = Vec::new();
    for cycle in 1..=usize::from(args.cycles) {
        for pose in cube.poses.iter().rev() {
            let (joints, command) = (pose.joints.clone(), pose.pose);
            rows.push(TestPoseRow { pose: pose.number, cycle, joints, command });
        }
    }
    write_test_plan(&args.out, &chain, load.as_ref(), &rows)?;
    let mm = |v: f64| significant(1e3 * v, 4);
    if args.json {
        print_json(&serde_json::json!({
            "edge_mm": 1e3 * cube.edge,
            "centre_mm": [1e3 * cube.centre.x, 1e3 * cube.centre.y, 1e3 * cube.centre.z],
            "cycles": args.cycles,
            "poses": cube.poses.iter().map(|pose| {
                let t = pose.pose.translation * 1e3;
                serde_json::json!({"name": format!("P{}", pose.number), "xyz_mm": [t.x, t.y, t.z],
                    "rpy_deg": pose.pose.rpy().map(f64::to_degrees)})
            }).collect::<Vec<_>>(),
        }))?;
    } else {
        terminal::print(&format!(
            "cube with an edge of {} mm, centre {} {} {} mm (base frame); P1 to P5 in its inclined plane, {}\n",
            mm(cube.edge),
            mm(cube.centre.x),
            mm(cube.centre.y),
            mm(cube.centre.z),
            count(usize::from(args.cycles), "cycle")
        ));
        for pose in &cube.poses {
            let [x, y, z]: [f64; 3] = pose.pose.translation.into();
            terminal::print(&format!(" P{}  {} {} {} mm\n", pose.number, mm(x), mm(y), mm(z)));
        }
        terminal::print(
            "The path between the poses is not checked for collisions. State load and speed (columns payload, speed) in the table.\n",
        );
    }
    terminal::log(&format!("wrote {}", args.out.display()));
    Ok(())
}
