//! A plant that is measured with everything: `simulate`, `check`, `identify` and `predict`, held against the true positions.

use crate::folder::Folder;
use crate::observations::cell::{kind, robot};
use std::fmt::Write as _;

/// What is known.
const DESCRIBED: &str = "[[landmarks]]\nname = \"A\"\nkind = \"socket\"\n\n\
    [[landmarks]]\nname = \"B\"\nkind = \"socket\"\n\n\
    [[landmarks]]\nname = \"wire\"\nkind = \"distance\"\nfree = [\"offset\"]\n\n\
    [[landmarks]]\nname = \"table\"\nkind = \"plane\"\n\n\
    [[landmarks]]\nname = \"ball\"\nkind = \"sphere\"\nradius = 60\n\n\
    [[landmarks]]\nname = \"gauge\"\nkind = \"linear\"\n\n\
    [[landmarks]]\nname = \"morning\"\nkind = \"relative\"\n\n\
    [[cameras]]\nname = \"wall\"\nfx = 800\nfy = 800\ncx = 640\ncy = 480\ndistortion = [-0.08]\nsize = [1280, 960]\n\n\
    [[cameras]]\nname = \"eye\"\nmount = \"tool\"\nfx = 900\nfy = 900\ncx = 640\ncy = 480\nsize = [1280, 960]\n";

/// What is true.
const PLANT: &str = r#"robot = "robot.toml"
seed = 11

[errors.geometric]
position_mm = 0.5
angle_mrad = 0.8

[instrument]
sd_um = 60

[campaign]
visits = 25
shuffled = true

[[landmarks]]
name = "A"
rows = 25
xyz_mm = [450, 200, 250]
sd_um = 20

[[landmarks]]
name = "B"
rows = 25
xyz_mm = [350, -300, 400]
sd_um = 20

[[landmarks]]
name = "wire"
rows = 40
xyz_mm = [1400, 500, -300]
offset_mm = 25
sd_um = 30

[[landmarks]]
name = "table"
rows = 30
xyz_mm = [400, 0, 100]
normal = [0, 0.1, 1]
sd_um = 30

[[landmarks]]
name = "ball"
rows = 30
xyz_mm = [400, 350, 450]
sd_um = 20

[[landmarks]]
name = "gauge"
rows = 30
normal = [0.6, 0.8, 0]
sd_um = 40

[[landmarks]]
name = "morning"
rows = 20
xyz_mm = [900, -200, 100]
rpy_deg = [5, 10, 100]
sd_um = 60

[[cameras]]
name = "wall"
images = 30
xyz_mm = [2200, 100, 500]
rpy_deg = [-90, 0, 90]
sd_px = 0.05

[[cameras]]
name = "eye"
images = 8
xyz_mm = [40, -50, 30]
rpy_deg = [3, -2, 40]
distance_mm = [250, 500]
normal = [0, 0, 1]
sd_px = 0.1
"#;

/// A board beside the arm.
fn described() -> String {
    let mut text = DESCRIBED.to_owned();
    for k in 0..12 {
        let (x, y) = (380 + 30 * (k % 4), 150 + 30 * (k / 4));
        write!(text, "\n[[landmarks]]\nname = \"c{k}\"\nxyz = [{x}, {y}, 50]\n").unwrap();
    }
    robot(&text)
}

/// x, y, z, mm.
fn places(text: &str) -> Vec<[f64; 3]> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |axis: &str| {
        let at = header.iter().position(|cell| cell.starts_with(&format!("{axis}["))).unwrap();
        (at, if header[at].ends_with("[mm]") { 1.0 } else { 1e3 })
    };
    let at = ["x", "y", "z"].map(column);
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        at.map(|(k, unit)| unit * cells[k].parse::<f64>().unwrap())
    };
    lines.map(row).collect()
}

#[test]
fn a_plant_is_measured_with_every_kind_and_what_is_identified_predicts_the_truth() {
    let folder = Folder::empty();
    folder.write("robot.toml", &described());
    folder.write("plant.toml", PLANT);
    let simulate = ["simulate", "--plant", "plant.toml", "--out", "data.csv", "--truth", "truth.csv"];
    folder.run(&simulate).ended(0);
    let again = folder.read("data.csv");
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    assert_eq!(again, folder.read("data.csv"));
    folder.run("check --robot robot.toml --data data.csv").ended(0);
    let words = "identify --robot robot.toml --data data.csv --out fit.json --json";
    let found = folder.run(words).ended(0).json();
    // What scatters is what was simulated: the standard deviations of the kinds, in their units.
    for (name, sd) in [("distance", 0.03), ("plane", 0.03), ("sphere", 0.02), ("linear", 0.04)] {
        let of = kind(&found, name)["sd"].as_f64().unwrap();
        assert!((of / sd).ln().abs() < 0.4, "{name}: {of} for {sd}");
    }
    folder.run("predict --fit fit.json --data data.csv --out p.csv").ended(0);
    let (predicted, truth) = (places(&folder.read("p.csv")), places(&folder.read("truth.csv")));
    assert_eq!(predicted.len(), truth.len());
    let square = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>();
    let rms = (predicted.iter().zip(&truth).map(square).sum::<f64>() / truth.len() as f64).sqrt();
    // Frames of 0.5 mm and 0.8 mrad are a millimetre and a half at the tool; noise is a few hundredths.
    assert!(rms < 0.05, "{rms} mm");
}

#[test]
fn what_is_wrong_with_a_plant_s_landmarks_is_told_with_its_place() {
    let folder = Folder::empty();
    folder.write("robot.toml", &described());
    for (from, to, words) in [
        ("name = \"wire\"", "name = \"wires\"", "plant.toml:28:8: the robot has no landmark `wires`"),
        ("rows = 25", "row = 25", "plant.toml:17:1: unknown field `row`"),
        (
            "xyz_mm = [450, 200, 250]",
            "xyz_mm = [9450, 200, 250]",
            "plant.toml:16:8: no posture within the joints' limits",
        ),
    ] {
        assert!(PLANT.contains(from), "{from}");
        folder.write("plant.toml", &PLANT.replacen(from, to, 1));
        let run = folder.run("simulate --plant plant.toml --out data.csv").ended(2);
        assert!(run.log.contains(words), "{words}\n{}", run.log);
        assert!(!folder.file("data.csv").exists());
    }
    folder.write("plant.toml", PLANT);
    let over = "simulate --plant plant.toml --out data.csv --truth robot.toml";
    folder.run(over).ended(2);
}

#[test]
fn plates_that_are_known_altogether_calibrate_an_arm() {
    let folder = Folder::empty();
    let (mut described, mut plant) = (String::new(), String::new());
    for (name, xyz, normal) in [
        ("floor", "[400, 0, 100]", "[0, 0, 1]"),
        ("wall", "[650, 0, 300]", "[1, 0, 0]"),
        ("side", "[400, 450, 300]", "[0, 1, 0]"),
    ] {
        let plate = format!(
            "\n[[landmarks]]\nname = \"{name}\"\nkind = \"plane\"\nxyz = {xyz}\nnormal = {normal}\nknown = true\n"
        );
        described.push_str(&plate);
        write!(plant, "\n[[landmarks]]\nname = \"{name}\"\nrows = 40\nsd_um = 20\n").unwrap();
    }
    folder.write("robot.toml", &robot(&described));
    let head = "robot = \"robot.toml\"\nseed = 3\n\n[errors.geometric]\nposition_mm = 0.3\nangle_mrad = 0.5\n\n[campaign]\nvisits = 0\n";
    folder.write("plant.toml", &format!("{head}{plant}"));
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    let words = "identify --robot robot.toml --data data.csv --out fit.json --json";
    let found = folder.run(words).ended(0).json();
    // Held out is a whole plate, which the two others say little of.
    let sd = kind(&found, "plane")["sd"].as_f64().unwrap();
    assert!((sd / 0.02f64).ln().abs() < 0.4, "{sd} mm");
}

/// A servo arm whose joints yield by degrees under its own links.
#[test]
fn a_soft_arm_is_fitted_to_the_noise() {
    const LINKS: [(&str, f64, f64, [f64; 3]); 4] = [
        ("waist", 0.05, 0.15, [0.0, 0.0, 1.0]),
        ("shoulder", 0.04, 0.12, [0.0, 1.0, 0.0]),
        ("elbow", 0.13, 0.10, [0.0, 1.0, 0.0]),
        ("wrist", 0.12, 0.08, [0.0, 1.0, 0.0]),
    ];
    let folder = Folder::empty();
    let mut robot =
        String::from("name = \"servo\"\ngravity = [0, 0, -9.81]\ntool = { xyz = [0.02, 0.01, 0.09] }\n");
    let mut plant = String::from("robot = \"robot.toml\"\nseed = 3\n");
    let mut model = String::from("[[effects]]\nfamily = \"geometric\"\n");
    for (name, z, mass, axis) in LINKS {
        write!(
            robot,
            "\n[[joints]]\nname = \"{name}\"\ntype = \"revolute\"\nlimits = [-110, 110]\norigin = {{ xyz = [0, 0, {z}], axis = {axis:?} }}\nmass = {mass}\ncom = [0, 0, 0.05]\n"
        )
        .unwrap();
        write!(plant, "\n[[errors.joint_compliance]]\njoint = \"{name}\"\nstiffness = 6\n").unwrap();
        write!(model, "\n[[effects]]\nfamily = \"joint_compliance\"\njoints = [\"{name}\"]\n").unwrap();
    }
    plant += "\n[errors.geometric]\nposition_mm = 0.3\nangle_mrad = 0.5\n\n[instrument]\nsd_um = 20\n\n[campaign]\npostures = \"random\"\nvisits = 60\npayloads_kg = [0, 0.2]\ncom_mm = [0, 0, 30]\n";
    folder.write("robot.toml", &robot);
    folder.write("plant.toml", &plant);
    folder.write("model.toml", &model);
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    let words =
        ["identify", "--robot", "robot.toml", "--model", "model.toml", "--data", "data.csv", "--json"];
    let found = folder.run(&words).ended(0).json();
    assert_eq!(found["converged"], true, "{:#}", found["warnings"]);
    let sd = found["noise"]["position_sd_mm"].as_f64().unwrap();
    assert!((sd / 0.020).ln().abs() < 0.3, "{sd}");
    let groups = found["groups"].as_array().unwrap();
    for name in ["shoulder", "elbow"] {
        let of = |group: &&serde_json::Value| {
            group["words"].as_str().unwrap().starts_with(&format!("compliance {name}"))
        };
        let group = groups.iter().find(of).unwrap();
        assert!((group["value"].as_f64().unwrap() * 6.0 - 1.0).abs() < 0.01, "{group:#}");
    }
}

/// A tool by touching one fixed tip from several postures (the controllers' four-point method): the arm is as described, and so its lengths are known.
#[test]
fn a_tool_is_found_from_one_tip_where_the_arm_is_frozen() {
    let folder = Folder::empty();
    folder.write(
        "robot.toml",
        &robot("[[landmarks]]\nname = \"tip\"\n").replacen("[tool]", "[tool]\nknown = false", 1),
    );
    folder.write("tool.toml", "[[effects]]\nfamily = \"geometric\"\nframes = [\"tool\"]\n");
    let plant = "robot = \"robot.toml\"\nseed = 5\n\n[[errors.displacement]]\nframe = \"tool\"\nxyz_mm = [12, -7, 30]\n\n[campaign]\nvisits = 0\n\n[[landmarks]]\nname = \"tip\"\nrows = 8\nxyz_mm = [450, 200, 250]\nsd_um = 20\n";
    folder.write("plant.toml", plant);
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    let words = ["identify", "--robot", "robot.toml", "--data", "data.csv", "--json", "--out", "fit.json"];
    let all = folder.run(&words).ended(2).log;
    assert!(all.contains("the scale is not determined"), "{all}");
    let run = folder.run(&[&words[..], &["--model", "tool.toml"]].concat()).ended(0);
    let found = run.json();
    let groups = found["groups"].as_array().unwrap();
    for (axis, true_mm) in [("x", 12.0), ("y", -7.0), ("z", 30.0)] {
        let of = |group: &&serde_json::Value| {
            group["words"].as_str().unwrap().starts_with(&format!("{axis}@tool"))
        };
        let group = groups.iter().find(of).unwrap_or_else(|| panic!("{groups:#?}"));
        let off = (1e3 * group["value"].as_f64().unwrap() - true_mm).abs();
        assert!(off < 0.1, "{group:#}");
    }
}
