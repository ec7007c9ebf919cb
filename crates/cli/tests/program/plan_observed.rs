//! `plan --observe`: what to touch and to look at next.

use crate::folder::Folder;
use std::path::{Path, PathBuf};

/// Exit code of what is wrong with an input.
const INPUT: i32 = 2;

fn example(name: &str, file: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name);
    let path: PathBuf = folder.join(file);
    path.to_str().expect("a path of text").to_owned()
}

fn column<'t>(table: &'t str, name: &str) -> Vec<&'t str> {
    let mut lines = table.lines();
    let at = lines.next().expect("a header").split(',').position(|word| word == name);
    let at = at.unwrap_or_else(|| panic!("no column {name}"));
    lines.map(|line| line.split(',').nth(at).expect("a cell")).collect()
}

#[test]
fn sockets_are_planned_before_anything_is_measured_and_after() {
    let folder = Folder::empty();
    let (robot, data) = (example("09_sockets", "robot.toml"), example("09_sockets", "measurements.csv"));
    folder.write("model.toml", "[[effects]]\nfamily = \"geometric\"\n");
    // Nobody has said where the sockets are.
    let first = ["plan", "--model", "model.toml", "--observe", &robot, "--out", "plan.csv", "--count", "24"];
    let refused = folder.run(&first).ended(INPUT).log;
    assert!(refused.contains("no row can be planned at its landmarks and sensors: A1, A2, B1"), "{refused}");
    // Postures that touch them are in the table that the example measured.
    let among = [&first[..], &["--among", &data]].concat();
    let told = folder.run(&among).ended(0).out;
    assert!(
        told.contains("24 new pose measurements: A1 ") && told.contains("with as many at random"),
        "{told}"
    );
    let plan = folder.read("plan.csv");
    assert!(column(&plan, "kind").iter().all(|kind| *kind == "same_point"));
    let postures: Vec<&str> = column(&plan, "j1[rad]");
    assert_eq!(postures.len(), 24);

    folder.run(&["identify", "--robot", &robot, "--data", &data, "--out", "fit.json"]).ended(0);
    let later =
        ["plan", "--fit", "fit.json", "--observe", &robot, "--out", "plan.csv", "--count", "24", "--json"];
    let told = folder.run(&later).ended(0).json();
    let number = |key: &str| told[key].as_f64().expect("a number");
    assert!(
        number("then_mm") < number("at_random_mm") && number("at_random_mm") < number("now_mm"),
        "{told}"
    );
    assert_eq!((told["new"].as_u64(), told["drawn"].as_bool()), (Some(24), Some(true)));
    let plan = folder.read("plan.csv");
    let names = column(&plan, "landmark");
    assert!(
        names.len() == 24 && names.iter().all(|name| ["A", "B", "C", "D", "E", "F"].contains(&&name[..1]))
    );
}

#[test]
fn a_camera_on_the_robot_is_told_where_to_look() {
    let folder = Folder::empty();
    let (robot, data) = (example("10_hand_eye", "robot.toml"), example("10_hand_eye", "measurements.csv"));
    folder.run(&["identify", "--robot", &robot, "--data", &data, "--out", "fit.json"]).ended(0);
    let fit = folder.json("fit.json");
    let place = &fit["provenance"]["cameras"]["eye"]["xyz_m"];
    assert!((place[0].as_f64().expect("a number") - 0.04).abs() < 1e-3, "{place}");
    let plan = ["plan", "--fit", "fit.json", "--observe", &robot, "--out", "plan.csv", "--count", "6"];
    let told = folder.run(&[&plan[..], &["--pool", "60"]].concat()).ended(0).out;
    assert!(told.contains("6 new pose measurements: eye 6"), "{told}");
    let table = folder.read("plan.csv");
    assert_eq!((column(&table, "kind"), column(&table, "landmark")), (vec!["pixel"; 6], vec!["eye"; 6]));
    let refused = folder.run(&[&plan[..], &["--target", "T9"]].concat()).ended(INPUT).log;
    assert!(refused.contains("the robot has no target `T9`"), "{refused}");
}
