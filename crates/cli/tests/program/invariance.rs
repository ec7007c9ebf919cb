//! A discovery does not depend on units or names.

use crate::folder::Folder;
use std::path::Path;

/// (Robot, measurements) of the second example.
fn example() -> (String, String) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/02_measured_robot");
    let read = |file: &str| std::fs::read_to_string(folder.join(file)).unwrap();
    (read("robot.toml"), read("measurements.csv"))
}

/// What is compared: (family, joint) of each finding, the verdict, and held-out RMS before and after, mm.
fn discovered(robot: &str, data: &str) -> (Vec<(String, String)>, String, [f64; 2]) {
    let folder = Folder::empty();
    folder.write("robot.toml", robot);
    folder.write("data.csv", data);
    let ran = folder.run("discover --robot robot.toml --data data.csv --rotations 99 --json").ended(0);
    let found = ran.json();
    let word = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let effects = found["effects"].as_array().unwrap();
    let rms = |part: &str| found[part]["holdout"]["rms_mm"].as_f64().unwrap();
    (
        effects.iter().map(|effect| (word(&effect["family"]), word(&effect["joint"]))).collect(),
        word(&found["verdict"]),
        [rms("before"), rms("after")],
    )
}

#[track_caller]
fn close(a: [f64; 2], b: [f64; 2]) {
    for (a, b) in a.into_iter().zip(b) {
        // A search amplifies the rounding of the cells; findings differ by far more.
        assert!((a - b).abs() < 1e-4 * b, "{a} {b}");
    }
}

#[cfg(feature = "slow")]
#[test]
fn units_and_names_change_no_finding() {
    let (robot, data) = example();
    let (effects, verdict, rms) = discovered(&robot, &data);
    assert!(!effects.is_empty());

    // Metres and radians.
    let mut lines = data.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let factor = |column: &str| match column {
        column if column.ends_with("[mm]") => 1e-3,
        column if column.ends_with("[deg]") => std::f64::consts::PI / 180.0,
        _ => 1.0,
    };
    let mut other = header.join(",").replace("[mm]", "[m]").replace("[deg]", "[rad]");
    for line in lines {
        let cells = line.split(',').zip(&header).map(|(cell, column)| match cell.parse::<f64>() {
            Ok(value) if factor(column) < 1.0 => format!("{:?}", value * factor(column)),
            _ => cell.to_owned(),
        });
        other += &format!("\n{}", cells.collect::<Vec<_>>().join(","));
    }
    other += "\n";

    // And names whose order is the opposite one.
    let names = [("j1", "z6"), ("j2", "y5"), ("j3", "x4"), ("j4", "w3"), ("j5", "v2"), ("j6", "u1")];
    let targets = [("R1", "C"), ("R2", "B"), ("R3", "A")];
    let renamed = |text: &str| {
        names.iter().chain(&targets).fold(text.to_owned(), |text, (old, new)| text.replace(old, new))
    };
    let (other_names, same_verdict, other_rms) = discovered(&renamed(&robot), &renamed(&other));
    let expected: Vec<_> = effects.iter().map(|(family, joint)| (family.clone(), renamed(joint))).collect();
    assert_eq!((other_names, same_verdict), (expected, verdict));
    close(other_rms, rms);
}
