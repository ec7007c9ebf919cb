//! Kinds of observation through the program: draw wires, planes, spheres and gauges, alone and beside positions.

mod camera;
pub mod cell;
mod eye;
#[cfg(feature = "slow")]
mod observers;
mod refused;
mod relative;

use crate::folder::Folder;
use cell::{ANCHOR, Cell, GAUGE, LANDMARKS, dot, identified, kind, minus, positions, robot};
use refused::INPUT;
use std::fmt::Write as _;

#[test]
fn kinds_of_one_number_calibrate_an_arm_without_a_tracker() {
    let mut cell = Cell::new(3);
    cell.wire(90).table(90).ball(60).gauge(60);
    let (folder, found) = identified(&cell, LANDMARKS);
    for (name, noise) in [("distance", 0.03), ("plane", 0.1), ("sphere", 0.02), ("linear", 0.04)] {
        let of = kind(&found, name);
        let sd = of["sd"].as_f64().unwrap();
        assert!((sd / noise).ln().abs() < 0.35, "{name}: {sd} mm for {noise} mm");
        let (before, held_out) = (of["before"].as_f64().unwrap(), of["held_out"].as_f64().unwrap());
        assert!(before > 3.0 * held_out && held_out < 2.5 * noise, "{name}: {before} → {held_out} mm");
    }
    let shares: f64 =
        found["kinds"]["kinds"].as_array().unwrap().iter().map(|k| k["share"].as_f64().unwrap()).sum();
    assert!((shares - 1.0).abs() < 1e-9, "{shares}");
    let verdict = found["verdict"].as_str().unwrap();
    assert!(
        verdict.starts_with("Residual by kind of observation (RMS), on held-out rows: distance"),
        "{verdict}"
    );
    let lengths = cell.lengths(&folder);
    assert!(lengths < 0.06, "{lengths} mm");
    // Each row has the predicted position of its target, whatever was measured there.
    folder.run("predict --fit fit.json --data data.csv --out q.csv").ended(0);
    assert_eq!(positions(&folder.read("q.csv")).len(), 300);
}

#[test]
fn kinds_beside_positions_are_better_than_positions_alone() {
    let mut cell = Cell::new(5);
    cell.positions(40);
    let (alone, _) = identified(&cell, LANDMARKS);
    let positions = cell.lengths(&alone);
    cell.wire(60).ball(40).gauge(40);
    let (together, found) = identified(&cell, LANDMARKS);
    let all = cell.lengths(&together);
    assert!(all < 0.7 * positions, "{all} mm, of positions alone {positions} mm");
    assert_eq!(kind(&found, "position")["rows"], 40);
    assert!(kind(&found, "position")["sd"].is_null());
    let text = together.run("identify --robot robot.toml --data data.csv").ended(0).out;
    for words in
        ["kinds of observation, RMS", "distance wire: x 1400.", "sphere ball: x 400.", "radius 60.000 mm"]
    {
        assert!(text.contains(words), "{words}\n{text}");
    }
    let compare = "compare --robot robot.toml --data data.csv --solver qr --solver huber(qr)";
    assert!(together.run(compare).ended(0).out.contains("huber(qr)"));
    together.run("check --robot robot.toml --data data.csv").ended(0);
}

#[test]
fn what_no_row_can_show_is_told() {
    for (rows, present, absent) in [
        (
            "plane",
            // Why nothing is fitted, and nothing else beside it.
            vec!["the scale is not determined: a robot as small as a point would agree with every row"],
            "the base is not determined",
        ),
        ("sphere", vec!["the base is not determined"], "the scale is not determined"),
        ("distance", vec!["the base is not determined"], "the scale is not determined"),
    ] {
        let mut cell = Cell::new(7);
        match rows {
            "plane" => cell.table(120),
            "sphere" => cell.ball(120),
            _ => cell.wire(120),
        };
        let folder = Folder::empty();
        folder.write("robot.toml", &robot(LANDMARKS));
        folder.write("data.csv", &cell.rows);
        let words = ["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "fit.json"];
        // A robot as small as a point would agree with a plane.
        let run = folder.run(&words).ended(if rows == "plane" { INPUT } else { 0 });
        for words in present {
            assert!(run.log.contains(words), "{words}\n{}", run.log);
        }
        assert!(absent.is_empty() || !run.log.contains(absent), "{absent}\n{}", run.log);
    }
}

#[test]
fn a_compliance_that_the_model_lacks_is_named_by_kinds_of_one_number() {
    // The second joint yields under its own load: a torque of the weight of the outer arm, worked out here by hand.
    let mut cell = Cell::new(9);
    let mut table = Cell::new(9);
    table.rows = cell.rows.replace("j6[rad]", "j6[rad],payload[kg],cx[mm],cy[mm],cz[mm]");
    for k in 0..240 {
        let q = cell.anywhere();
        let mass = [0.0, 4.0, 8.0][k % 3];
        // Joint 2 turns about a horizontal axis: the moment of a mass at the tip, N m, about it.
        let mut bent = cell.offsets;
        for _ in 0..3 {
            let [x, y, _] = cell.arm.tip(&q, &bent);
            let axis = q[0] + cell.offsets[0];
            let out = x * axis.cos() + y * axis.sin();
            bent[1] = cell.offsets[1] - 2e-5 * mass * 9.81 * out;
        }
        let tip = cell.arm.tip(&q, &bent);
        let away = minus(tip, ANCHOR);
        let length = dot(away, away).sqrt() + 0.025 + 3e-5 * cell.draw.noise();
        let along = 0.2 + dot(GAUGE, tip) + 4e-5 * cell.draw.noise();
        let cells = match k % 2 {
            0 => format!("distance,wire,{:.5},,,,,,", 1e3 * length),
            _ => format!("linear,gauge,,{:.5},,,,,", 1e3 * along),
        };
        let q: Vec<String> = q.iter().map(|q| format!("{q:.9}")).collect();
        writeln!(table.rows, "{cells},{},{mass},0,0,0", q.join(",")).unwrap();
    }
    let folder = Folder::empty();
    folder.write("robot.toml", &("gravity = [0, 0, -9.81]\n".to_owned() + &robot(LANDMARKS)));
    folder.write("data.csv", &table.rows);
    let words = "discover --robot robot.toml --data data.csv --out fit.json --report r --json";
    let found = folder.run(words).ended(0).json();
    let effects = found["effects"].as_array().unwrap();
    assert!(effects.iter().any(|e| e["family"] == "joint_compliance" && e["joint"] == "j2"), "{effects:#?}");
    assert!(found["kinds"]["kinds"].as_array().unwrap().len() == 2);
}
