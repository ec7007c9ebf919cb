//! Points that a target touched: what of a table and of a robot file is refused, and a measured robot without an instrument.

use crate::folder::{Folder, ROBOT};
use std::path::Path;

/// Exit code of what is wrong with an input.
const INPUT: i32 = 2;

const TABLE: &str = "kind,landmark,j1[deg],j2[deg],d3[mm],target\n\
    same_point,A,10,20,100,T1\nsame_point,A,30,-20,120,T1\nsame_point,B,5,50,60,T1\nsame_point,B,-15,40,80,T1\n";

fn told(robot: &str, table: &str) -> String {
    let folder = Folder::empty();
    folder.write("robot.toml", robot);
    folder.write("data.csv", table);
    let run = folder.run("identify --robot robot.toml --data data.csv --out fit.json");
    assert!(!folder.file("fit.json").exists(), "{}", run.log);
    run.ended(INPUT).log
}

#[test]
fn what_is_wrong_with_a_landmark_is_told_where_it_stands() {
    let landmarks = "\n[[landmarks]]\nname = \"A\"\nkind = \"socket\"\n\n[[landmarks]]\nname = \"B\"\n";
    let robot = |more: &str| format!("{ROBOT}{landmarks}{more}");
    for (more, table, words) in [
        ("", TABLE.replace(",B,5", ",C,5"), "data.csv:4: the robot file has no landmark `C`"),
        (
            "",
            TABLE.replace("same_point,B,-15", "same_pint,B,-15"),
            "`same_pint` is no kind of observation; did you mean `same_point`?",
        ),
        (
            "",
            TABLE.replace("same_point,B,-15", "position,B,-15"),
            "data.csv:5: column `landmark` (2): is not used by a measured position",
        ),
        ("", TABLE.replace(",B,-15", ",,-15"), "data.csv:5: column `landmark` (2): is empty"),
        ("", TABLE.replace("kind,", "why,"), "column `landmark` (2): needs a column `kind`"),
        ("", TABLE.replace("landmark,", "why,"), "`same_point` needs a column `landmark`"),
        ("", TABLE.replace("same_point,B,-15,40,80,T1\n", ""), "landmark B: one row touched it"),
        ("\n[[distances]]\nbetween = [\"A\", \"X\"]\nvalue = 50\n", TABLE.into(), "there is no landmark `X`"),
        ("\n[[distances]]\nbetween = [\"A\", \"A\"]\nvalue = 50\n", TABLE.into(), "names one landmark twice"),
        ("\n[[distances]]\nbetween = [\"A\", \"B\"]\nvalue = 0\n", TABLE.into(), "a distance is above zero"),
        ("\n[[landmarks]]\nname = \"C\"\nknown = true\n", TABLE.into(), "is known, but has no `xyz`"),
        ("\n[[landmarks]]\nname = \"A\"\n", TABLE.into(), "landmark `A` stands twice"),
    ] {
        let log = told(&robot(more), &table);
        assert!(log.contains(words), "{words}\n{log}");
    }
    let measured = TABLE.replace("target\n", "target,x[mm],y[mm],z[mm]\n").replace(",T1\n", ",T1,1,2,3\n");
    let log = told(&robot(""), &measured);
    assert!(log.contains("column `x[mm]` (7): a row of kind `same_point` has no measured position"), "{log}");
}

/// The measured robot of the shared data; none where that is not there.
fn panda(folder: &Folder, name: &str) -> bool {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(name);
    let Ok(text) = std::fs::read_to_string(from.join("observations.csv")) else {
        println!("SKIPPED: {} is not there", from.display());
        return false;
    };
    let mut robot = std::fs::read_to_string(from.join("robot.toml")).unwrap();
    let (mut table, mut sockets) = (String::new(), Vec::<String>::new());
    for (k, line) in text.lines().enumerate() {
        let (position, rest) = line.split_once(',').unwrap();
        let (socket, joints) = rest.split_once(',').unwrap();
        if k == 0 {
            table += &format!("kind,landmark,{joints}\n");
            continue;
        }
        let name = format!("{position} {socket}");
        table += &format!("same_point,{name},{joints}\n");
        if !sockets.contains(&name) {
            robot += &format!("\n[[landmarks]]\nname = \"{name}\"\n");
            sockets.push(name);
        }
    }
    for first in sockets.iter().filter(|name| name.ends_with("hole_0")) {
        let second = first.replace("hole_0", "hole_1");
        robot +=
            &format!("\n[[distances]]\nbetween = [\"{first}\", \"{second}\"]\nvalue = 0.05\nsd = 0.0001\n");
    }
    folder.write("robot.toml", &robot);
    folder.write("data.csv", &table);
    true
}

#[test]
fn a_distance_may_name_points_of_the_data() {
    let folder = Folder::empty();
    folder.write("data.csv", TABLE);
    let distance =
        |a: &str, b: &str| format!("{ROBOT}\n[[distances]]\nbetween = [\"{a}\", \"{b}\"]\nvalue = 50\n");
    let words = "identify --robot robot.toml --data data.csv";
    folder.write("robot.toml", &distance("A", "B"));
    let run = folder.run(words).ended(0);
    assert!(!run.log.contains("the scale is not determined"), "{}", run.log);
    folder.write("robot.toml", &distance("A", "C"));
    let run = folder.run(words).ended(0);
    assert!(run.log.contains("the distance from A to C is not used"), "{}", run.log);
    assert!(run.log.contains("no row touched landmark C"), "{}", run.log);
}

#[test]
fn a_measured_arm_without_an_instrument() {
    let folder = Folder::empty();
    if !panda(&folder, "mukca-panda-3") {
        return;
    }
    let words = "identify --robot robot.toml --data data.csv --out fit.json --json";
    let found = folder.run(words).ended(0).json();
    let landmarks = &found["landmarks"];
    let spread = landmarks["held_out"]["rms_mm"].as_f64().unwrap();
    let distance = landmarks["distance_rms_mm"].as_f64().unwrap();
    assert_eq!(landmarks["suspects"], serde_json::json!([]));
    assert!(spread <= 0.235 && distance <= 0.055, "{spread} mm, distances {distance} mm");
    assert!(
        found["verdict"].as_str().unwrap().starts_with("Spread at the landmarks"),
        "{}",
        found["verdict"]
    );
    // The fit is that of a robot: it predicts without landmarks.
    let rows: String = folder
        .read("data.csv")
        .lines()
        .map(|line| line.splitn(3, ',').nth(2).unwrap().to_owned() + "\n")
        .collect();
    folder.write("joints.csv", &rows);
    folder.run("predict --fit fit.json --data joints.csv --out p.csv").ended(0);
    folder.run("predict --fit fit.json --data data.csv --out q.csv").ended(0);
    assert_eq!(folder.read("p.csv"), folder.read("q.csv"));
}

#[test]
fn a_measured_arm_whose_scale_nobody_knows_keeps_its_size() {
    let folder = Folder::empty();
    if !panda(&folder, "mukca-panda-3") {
        return;
    }
    let robot = folder.read("robot.toml");
    folder.write("robot.toml", robot.split("\n[[distances]]").next().unwrap());
    let words = ["identify", "--robot", "robot.toml", "--data", "data.csv", "--json"];
    let run = folder.run(&words).ended(0);
    let found = run.json();
    let landmarks = &found["landmarks"];
    let spread = landmarks["held_out"]["rms_mm"].as_f64().unwrap();
    assert!((0.1..0.3).contains(&spread), "{spread} mm");
    let remarks = landmarks["remarks"].to_string();
    assert!(remarks.contains("the scale is not determined"), "{remarks}");
    assert!(remarks.contains("the fit keeps the scale of the robot as described"), "{remarks}");
    let text = folder.run(&words[..5]).ended(0).out;
    assert!(text.contains("No distance is known: the spread says nothing about lengths."), "{text}");
    // Both holes of a place are 50 mm apart.
    let at = |k: usize| -> Vec<f64> {
        let xyz = landmarks["points"][k]["xyz_mm"].as_array().unwrap();
        xyz.iter().map(|value| value.as_f64().unwrap()).collect()
    };
    let apart = at(0).iter().zip(at(1)).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    assert!((apart - 50.0).abs() < 1.0, "{apart} mm");
}
