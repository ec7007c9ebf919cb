//! What is handed over: parameters in the robot's own description, commands in frames, corrected poses.

use crate::folder::Folder;
use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::Vector3;

/// Six joints in rows of Denavit and Hartenberg, with a negative a, and frames.
const ARM: &str = r#"name = "arm"
[units]
length = "mm"
angle = "deg"
[base]
xyz = [1200, -300, 100]
rpy = [0, 0, 30]
[[joints]]
name = "j1"
dh = { theta = 0, d = 300, a = 0, alpha = 90 }
type = "revolute"
[[joints]]
name = "j2"
dh = { theta = 0, d = 0, a = -612, alpha = 0 }
type = "revolute"
[[joints]]
name = "j3"
dh = { theta = 0, d = 0, a = -572, alpha = 0 }
type = "revolute"
[[joints]]
name = "j4"
dh = { theta = 0, d = 164, a = 0, alpha = 90 }
type = "revolute"
[[joints]]
name = "j5"
dh = { theta = 0, d = 116, a = 0, alpha = -90 }
type = "revolute"
[[joints]]
name = "j6"
dh = { theta = 0, d = 92, a = 0, alpha = 0 }
type = "revolute"
[tool]
xyz = [0, 30, 120]
[[frames]]
name = "fixture"
xyz = [500, 200, 50]
rpy = [0, 0, 90]
[[frames]]
name = "gripper"
in = "flange"
xyz = [0, 0, 150]
rpy = [0, 20, 0]
"#;

const PLANT: &str = "robot = \"arm.toml\"\nseed = 5\n[errors.geometric]\nposition_mm = 0.5\nangle_mrad = 0.6\n\
                     [instrument]\nsd_um = 10\norientation_urad = 20\n[campaign]\npostures = \"random\"\nvisits = 60\n";

fn fitted() -> Folder {
    let folder = Folder::empty();
    folder.write("arm.toml", ARM);
    folder.write("plant.toml", PLANT);
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    let identify = "identify --robot arm.toml --data data.csv --out fit.json";
    let said = folder.run(&format!("{identify} --parameters p.csv")).ended(0).out;
    assert!(said.contains("zero offsets of the joints"), "{said}");
    folder
}

/// Rows of a CSV file without its header and comments.
fn rows(text: &str) -> Vec<Vec<String>> {
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines.map(|line| line.split(',').map(String::from).collect()).collect()
}

fn numbers(cells: &[String]) -> Vec<f64> {
    cells.iter().map(|cell| cell.parse().unwrap_or_else(|_| panic!("{cell} is no number"))).collect()
}

/// The calibrated numbers of a part, in m and rad.
fn part(folder: &Folder, file: &str, name: &str) -> Vec<f64> {
    let of = |row: &Vec<String>| {
        let value: f64 = row[5].parse().unwrap();
        if row[2] == "mm" { value / 1e3 } else { value.to_radians() }
    };
    let all = rows(&folder.read(file));
    all.iter().filter(|row| row[0] == name && row[1] != "zero_offset").map(of).collect()
}

fn placed(numbers: &[f64]) -> Pose {
    Pose::from_xyz_rpy([numbers[0], numbers[1], numbers[2]], [numbers[3], numbers[4], numbers[5]])
}

/// The calibrated flange in the base, multiplied out from the numbers of the file.
fn flange(folder: &Folder, joints: &[f64]) -> Pose {
    let mut at = Pose::IDENTITY;
    for (k, q) in joints.iter().enumerate() {
        let mut row = part(folder, "p.csv", &format!("j{}", k + 1));
        row.resize(5, 0.0);
        at = at
            * Pose::rot(2, row[0] + q)
            * Pose::trans(2, row[1])
            * Pose::trans(0, row[2])
            * Pose::rot(0, row[3])
            * Pose::rot(1, row[4]);
    }
    at
}

fn nominal_flange(joints: &[f64]) -> Pose {
    let rows = [
        (0.3, 0.0, 90f64),
        (0.0, -0.612, 0.0),
        (0.0, -0.572, 0.0),
        (0.164, 0.0, 90.0),
        (0.116, 0.0, -90.0),
        (0.092, 0.0, 0.0),
    ];
    joints.iter().zip(rows).fold(Pose::IDENTITY, |at, (q, (d, a, alpha))| {
        at * Pose::rot(2, *q) * Pose::trans(2, d) * Pose::trans(0, a) * Pose::rot(0, alpha.to_radians())
    })
}

#[track_caller]
fn same(a: &Pose, b: &Pose) {
    near(a, b, 1e-8);
}

#[track_caller]
fn near(a: &Pose, b: &Pose, most: f64) {
    let (p, r) = ((a.translation - b.translation).norm(), (a.rotation - b.rotation).amax());
    assert!(p < most && r < most, "{p:e} m, {r:e}");
}

/// Where base and flange are is a choice of the fit, and of the table of parameters, which agree to second order: 0.6 mrad squared.
const SECOND_ORDER: f64 = 2e-6;

const PROGRAMME: &str =
    "j1[deg],j2[deg],j3[deg],j4[deg],j5[deg],j6[deg]\n10,-70,80,-20,60,15\n-35,-100,95,20,80,-40\n";

#[test]
fn parameters_come_back_on_their_branch_and_predict() {
    let folder = fitted();
    let all = rows(&folder.read("p.csv"));
    for row in all.iter().filter(|row| row[0].starts_with('j')) {
        let delta: f64 = row[4].parse().unwrap();
        assert!(delta.abs() < 10.0, "{row:?}");
    }
    let a: f64 = all.iter().find(|row| row[0] == "j2" && row[1] == "a").unwrap()[5].parse().unwrap();
    assert!((a + 612.0).abs() < 5.0);
    // As the program predicts: base · rows · tool.
    folder.write("q.csv", PROGRAMME);
    folder.run("predict --fit fit.json --data q.csv --out at.csv").ended(0);
    for (given, found) in rows(PROGRAMME).iter().zip(rows(&folder.read("at.csv"))) {
        let q: Vec<f64> = numbers(given).iter().map(|v| v.to_radians()).collect();
        let base = placed(&part(&folder, "p.csv", "base"));
        let tool = placed(&part(&folder, "p.csv", "tool"));
        let at = base * flange(&folder, &q) * tool;
        let said = numbers(&found[6..13]);
        let rotation = Pose::rotation_from_quaternion([said[3], said[4], said[5], said[6]]);
        same(&at, &Pose::new(rotation, Vector3::new(said[0], said[1], said[2])));
    }
    // The same table from the fit alone, and rows of dh with the same numbers.
    folder.run("export --fit fit.json --format parameters --out again.csv").ended(0);
    assert_eq!(folder.read("p.csv"), folder.read("again.csv"));
    folder.run("export --fit fit.json --format dh --out dh.csv").ended(0);
    let dh = rows(&folder.read("dh.csv"));
    let of_file: f64 = dh.iter().find(|row| row[0] == "j2").unwrap()[4].parse().unwrap();
    assert!((1e3 * of_file - a).abs() < 1e-9);
}

#[test]
fn commands_reach_poses_of_a_tool_in_a_work_object() {
    let folder = fitted();
    // A pose of the gripper in the fixture, that the nominal robot reaches.
    let fixture = Pose::from_xyz_rpy([0.5, 0.2, 0.05], [0.0, 0.0, 90f64.to_radians()]);
    let gripper = Pose::from_xyz_rpy([0.0, 0.0, 0.15], [0.0, 20f64.to_radians(), 0.0]);
    let q: Vec<f64> = [10f64, -70.0, 80.0, -20.0, 60.0, 15.0].map(f64::to_radians).to_vec();
    let wanted = fixture.inverse() * nominal_flange(&q) * gripper;
    let ([x, y, z], [qw, qx, qy, qz]) = (<[f64; 3]>::from(wanted.translation), wanted.quaternion());
    let header = "j1[deg],j2[deg],j3[deg],j4[deg],j5[deg],j6[deg],x[m],y[m],z[m],qw,qx,qy,qz";
    folder.write("t.csv", &format!("{header}\n10,-70,80,-20,60,15,{x},{y},{z},{qw},{qx},{qy},{qz}\n"));
    let compensate = ["compensate", "--fit", "fit.json", "--poses", "t.csv", "--out", "c.csv", "--cartesian"];
    let at = ["--frame", "fixture", "--tcp", "gripper"];
    folder.run(&[&compensate[..], &at].concat()).ended(0);
    let row = rows(&folder.read("c.csv")).remove(0);
    assert_eq!(row[6], "ok");
    let joints: Vec<f64> = numbers(&row[..6]).iter().map(|v| v.to_radians()).collect();
    // The calibrated robot is there, and the nominal one at the corrected pose.
    near(&(fixture.inverse() * flange(&folder, &joints) * gripper), &wanted, SECOND_ORDER);
    let said = numbers(&row[11..18]);
    let corrected = Pose::new(
        Pose::rotation_from_quaternion([said[3], said[4], said[5], said[6]]),
        Vector3::new(said[0], said[1], said[2]),
    );
    same(&(fixture.inverse() * nominal_flange(&joints) * gripper), &corrected);
    assert!((corrected.translation - wanted.translation).norm() > 1e-4);
    // The same frames, given as numbers; and the same joints from a programme of joints.
    let frames = ["--frame=500mm,200mm,50mm,0,0,90", "--tcp=0mm,0mm,150mm,0,20,0"];
    folder.run(&[&compensate[..], &frames].concat()).ended(0);
    for (a, b) in numbers(&rows(&folder.read("c.csv"))[0][..6]).iter().zip(numbers(&row[..6])) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
    folder.write("q.csv", PROGRAMME);
    let programme = "compensate --fit fit.json --joints q.csv --out k.csv";
    folder.run(programme).ended(0);
    let found = rows(&folder.read("k.csv"));
    for (given, found) in rows(PROGRAMME).iter().zip(&found) {
        let radians = |cells: &[String]| numbers(cells).iter().map(|v| v.to_radians()).collect::<Vec<f64>>();
        near(&flange(&folder, &radians(&found[..6])), &nominal_flange(&radians(given)), SECOND_ORDER);
    }
    for (a, b) in numbers(&found[0][..6]).iter().zip(numbers(&row[..6])) {
        assert!((a - b).abs() < 5e-4, "{a} {b}");
    }
}

#[test]
fn commands_and_plans_have_the_units_of_a_pendant() {
    let folder = fitted();
    let q: Vec<f64> = [10f64, -70.0, 80.0, -20.0, 60.0, 15.0].map(f64::to_radians).to_vec();
    let wanted = nominal_flange(&q);
    let ([x, y, z], [roll, pitch, yaw]) =
        (<[f64; 3]>::from(1e3 * wanted.translation), wanted.rpy().map(f64::to_degrees));
    folder.write(
        "t.csv",
        &format!("X[mm],Y[mm],Z[mm],A[deg],B[deg],C[deg]\n{x},{y},{z},{yaw},{pitch},{roll}\n"),
    );
    let run = ["compensate", "--fit", "fit.json", "--poses", "t.csv", "--out", "c.csv", "--cartesian"];
    let run = [&run[..], &["--frame", "base", "--tcp", "flange", "--orientation", "abc"]].concat();
    folder.run(&run).ended(0);
    let in_si = folder.read("c.csv");
    folder.run(&[&run[..], &["--units", "deg,mm"]].concat()).ended(0);
    let in_units = folder.read("c.csv");
    assert!(in_units.starts_with("j1[deg],j2[deg]"), "{in_units}");
    let names =
        "corrected_x[mm],corrected_y[mm],corrected_z[mm],corrected_a[deg],corrected_b[deg],corrected_c[deg]";
    assert!(in_units.lines().next().unwrap().ends_with(names), "{in_units}");
    let (si, own) = (rows(&in_si).remove(0), rows(&in_units).remove(0));
    for (a, b) in numbers(&si[..6]).iter().zip(numbers(&own[..6])) {
        assert!((a.to_degrees() - b).abs() < 1e-9, "{a} {b}");
    }
    let (si, own) = (numbers(&si[11..18]), numbers(&own[11..17]));
    let quaternion = Pose::rotation_from_quaternion([si[3], si[4], si[5], si[6]]);
    let [a, b, c] = [own[3], own[4], own[5]].map(f64::to_radians);
    let kuka = Pose::rot(2, a) * Pose::rot(1, b) * Pose::rot(0, c);
    same(
        &Pose::new(kuka.rotation, Vector3::new(own[0], own[1], own[2]) / 1e3),
        &Pose::new(quaternion, Vector3::new(si[0], si[1], si[2])),
    );
    let plan = "plan --fit fit.json --out p.csv --count 3 --pool 20";
    folder.run(plan).ended(0);
    let in_si = rows(&folder.read("p.csv"));
    folder.run(&format!("{plan} --units deg")).ended(0);
    assert!(folder.read("p.csv").starts_with("visit,j1[deg],"), "{}", folder.read("p.csv"));
    for (si, own) in in_si.iter().zip(rows(&folder.read("p.csv"))) {
        assert!((numbers(&si[1..2])[0].to_degrees() - numbers(&own[1..2])[0]).abs() < 1e-9, "{si:?} {own:?}");
    }
    let refused = folder.run(&format!("{plan} --units kg")).ended(2).log;
    assert!(refused.contains("`kg` is no unit of an angle (rad, deg) or a length"), "{refused}");
}

#[test]
fn frames_that_are_not_there_are_named() {
    let folder = fitted();
    folder.write("t.csv", "x[mm],y[mm],z[mm]\n500,0,500\n");
    let compensate = ["compensate", "--fit", "fit.json", "--poses", "t.csv", "--out", "c.csv"];
    let refused = |more: &[&str]| folder.run(&[&compensate[..], more].concat()).ended(2).log;
    let said = refused(&["--frame", "fixtur"]);
    assert_eq!(said, "error: --frame: there is no frame `fixtur` (known: fixture, gripper)\n");
    let said = refused(&["--frame", "gripper"]);
    assert!(said.contains("moves with the robot"), "{said}");
    let said = refused(&["--tcp", "fixture"]);
    assert!(said.contains("does not move with the robot"), "{said}");
    let said = refused(&["--tcp", "gripper"]);
    assert_eq!(
        said,
        "error: t.csv:2: the pose has no orientation; with --tcp it has to be that of the tool centre point\n"
    );
    assert!(!folder.names().contains(&"c.csv".to_owned()));
}

#[test]
fn a_map_has_the_same_quantity_before_and_after() {
    let folder = fitted();
    let map = ["map", "--fit", "fit.json", "--out", "m.csv", "--points", "2"];
    let said = folder.run(&map).ended(0).out;
    let header = folder.read("m.csv").lines().next().unwrap().to_owned();
    assert!(header.ends_with("status,before[m],before_95[m],after_95[m],extrapolates,beyond"), "{header}");
    for row in rows(&folder.read("m.csv")) {
        let [before, before_95, after_95] = [10, 11, 12].map(|k| row[k].parse::<f64>().unwrap());
        assert!(before < before_95 && after_95 > 0.0, "{row:?}");
    }
    assert!(said.contains("before compensation (95 % bound of each place)"), "{said}");
}

/// Seven joints of which the reflector, 90 mm in front of the last one, hardly shows where the sixth stands.
#[test]
fn what_a_description_cannot_carry_turns_no_axis_of_it() {
    let folder = Folder::empty();
    folder.run("init xarm7 --out library.toml").ended(0);
    let described = folder.read("library.toml");
    let joints = described.split("# Where the robot stands").next().expect("a first part");
    let placed = "[base]\nxyz = [900, 300, 20]\nrpy = [0, 0, -75]\n\n[tool]\nxyz = [0, 0, 90]\n";
    folder.write("arm.toml", &format!("{joints}{placed}"));
    let plant = "robot = \"arm.toml\"\nseed = 83\n[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.5\n\
                 [[errors.backlash]]\njoint = \"J2\"\nwidth_mrad = 0.6\n[instrument]\nstation_mm = [0, 0, 0]\nsd_um = 12\n\
                 transverse_um_per_m = 4\nradial_um_per_m = 0.5\n[repeatability]\nsd_um = 30\n\
                 [campaign]\npostures = \"random\"\nvisits = 60\nrepeats = 2\nvisit_s = 50\n";
    folder.write("plant.toml", plant);
    folder.write(
        "model.toml",
        "[[effects]]\nfamily = \"geometric\"\n[[effects]]\nfamily = \"backlash\"\njoint = \"J2\"\n",
    );
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    let identify = "identify --robot arm.toml --model model.toml --data data.csv";
    folder.run(&format!("{identify} --out fit.json --parameters p.csv")).ended(0);
    // Backlash has no row. What it moves on these poses is no reason for an axis that stands 3° elsewhere (it was), or a length of 10 mm more.
    let mut compared = 0;
    for row in rows(&folder.read("p.csv")) {
        let (of_joint, delta) = (row[0].starts_with('J'), row[4].parse::<f64>());
        let Ok(delta) = delta else { continue };
        let most = if row[2] == "deg" { 0.3 } else { 2.0 };
        assert!(!of_joint || delta.abs() < most, "{row:?}");
        compared += usize::from(of_joint);
    }
    assert!(compared > 24, "{compared}");
    let written = folder.run("export --fit fit.json --format dh --out dh.csv").ended(0);
    assert!(written.out.contains("→ this file 0.14"), "{}", written.out);
}
