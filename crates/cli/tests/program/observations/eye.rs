//! A camera on the flange that looks at a board, of which nothing is known but the board's own points: pixels by formulas of the test's own.

use super::cell::{Arm, Draw, TOOL, dot, kind, minus, robot};
use super::refused::INPUT;
use crate::folder::Folder;
use std::fmt::Write as _;
use std::path::Path;

/// Where the camera is on the flange, m, and its axes to the right, down and ahead, in the flange's axes.
const AT: [f64; 3] = [-0.04, 0.05, 0.03];
const LOOKS: [[f64; 3]; 3] = [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];
/// The board's origin and its first two axes, in the robot's frame.
const BOARD: [f64; 3] = [0.42, 0.18, -0.12];
const ACROSS: [[f64; 3]; 2] = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0]];
const NOISE: f64 = 0.08;

fn corners() -> Vec<[f64; 2]> {
    (0..24).map(|k| [0.03 * f64::from(k % 6), 0.03 * f64::from(k / 6)]).collect()
}

struct Eye {
    arm: Arm,
    offsets: [f64; 6],
    draw: Draw,
}

impl Eye {
    /// What the camera sees of the board; none where a corner is outside of the image.
    fn sees(&self, q: &[f64; 6]) -> Option<Vec<[f64; 2]>> {
        let at = self.arm.point(q, &self.offsets, AT);
        let axes = LOOKS.map(|axis| {
            let end = [0, 1, 2].map(|k| AT[k] + axis[k]);
            minus(self.arm.point(q, &self.offsets, end), at)
        });
        let see = |b: [f64; 2]| {
            let p = [0, 1, 2].map(|k| BOARD[k] + ACROSS[0][k] * b[0] + ACROSS[1][k] * b[1]);
            let [x, y, z] = axes.map(|axis| dot(axis, minus(p, at)));
            let (x, y) = (x / z, y / z);
            let radial = 1.0 - 0.08 * (x * x + y * y);
            let [u, v] = [900.0 * x * radial + 640.0, 900.0 * y * radial + 480.0];
            (z > 0.15 && z < 0.9 && (2.0..1278.0).contains(&u) && (2.0..958.0).contains(&v)).then_some([u, v])
        };
        corners().into_iter().map(see).collect()
    }

    fn images(&mut self, count: usize) -> String {
        self.images_of(count, 0.0)
    }

    /// The same by an arm whose joints come to rest with this standard deviation, rad, once an image.
    fn images_of(&mut self, count: usize, scatter: f64) -> String {
        let mut text = String::from(
            "kind,landmark,point,u[px],v[px],visit,j1[rad],j2[rad],j3[rad],j4[rad],j5[rad],j6[rad]\n",
        );
        let mut image = 0;
        while image < count {
            let q: [f64; 6] = std::array::from_fn(|_| 2.9 * self.draw.next());
            let rests = q.map(|q| q + scatter * if scatter > 0.0 { self.draw.noise() } else { 0.0 });
            let Some(pixels) = self.sees(&rests) else { continue };
            let cells = q.map(|q| format!("{q:.9}")).join(",");
            for (k, [u, v]) in pixels.iter().enumerate() {
                let [u, v] = [u + NOISE * self.draw.noise(), v + NOISE * self.draw.noise()];
                writeln!(text, "pixel,eye,c{k},{u:.4},{v:.4},{image},{cells}").unwrap();
            }
            image += 1;
        }
        text
    }
}

fn described() -> String {
    let mut text = String::from(
        "[base]\nknown = false\n\n[[cameras]]\nname = \"eye\"\nmount = \"tool\"\nfx = 900\nfy = 900\ncx = 640\ncy = 480\ndistortion = [-0.08]\nsize = [1280, 960]\n",
    );
    for (k, [x, y]) in corners().iter().enumerate() {
        write!(text, "\n[[landmarks]]\nname = \"c{k}\"\nxyz = [{}, {}, 0]\n", 1e3 * x, 1e3 * y).unwrap();
    }
    robot(&text)
}

#[test]
fn a_camera_on_the_flange_and_the_base_are_found_from_a_board() {
    let (arm, offsets) = Arm::real(13);
    let mut eye = Eye { arm, offsets, draw: Draw::new(4) };
    let folder = Folder::empty();
    folder.write("robot.toml", &described());
    let data = eye.images(36);
    folder.write("data.csv", &data);
    folder.run("check --robot robot.toml --data data.csv").ended(0);
    let words = "identify --robot robot.toml --data data.csv --out fit.json --json";
    let found = folder.run(words).ended(0).json();
    let of = kind(&found, "pixel");
    let number = |key: &str| of[key].as_f64().unwrap();
    assert!((number("sd") / NOISE).ln().abs() < 0.2, "{of:#}");
    assert!(number("before") > 5.0 * number("held_out"), "{of:#}");
    assert!(number("held_out") < 2.0 * NOISE, "{of:#}");
    // Its place on the tool, by the stated intervals of its three coordinates.
    let sensor = &found["kinds"]["sensors"][0];
    for (k, (at, tool)) in AT.iter().zip(TOOL).enumerate() {
        let number = |list: &str| sensor[list][k][1].as_f64().unwrap();
        let off = (number("values") - 1e3 * (at - tool)).abs();
        assert!(off < 1.5 * number("within_95") && number("within_95") < 4.0, "{off} mm of {sensor:#}");
    }
    // The fit holds the robot alone.
    let fit = folder.read("fit.json");
    assert!(!fit.contains("seen~") && !fit.contains("point~"));
    folder.write("new.csv", "j1[rad],j2[rad],j3[rad],j4[rad],j5[rad],j6[rad]\n0.1,-0.5,0.8,0.2,0.1,0.3\n");
    folder.run("predict --fit fit.json --data new.csv --out p.csv").ended(0);
    folder.run("predict --fit fit.json --data data.csv --out p.csv").ended(0);
    // A third of the corners.
    let few: String =
        data.lines().enumerate().filter(|(k, _)| k % 3 == 0).map(|(_, line)| format!("{line}\n")).collect();
    folder.write("few.csv", &few);
    folder.run("discover --robot robot.toml --data few.csv --out d.json --report r").ended(0);
    assert!(!folder.read("d.json").contains("seen~"));
}

/// Of an arm that repeats no better than its images are read: 48 numbers of an image share one standstill.
#[test]
fn an_image_is_one_pose_measurement() {
    let (arm, offsets) = Arm::real(13);
    let mut eye = Eye { arm, offsets, draw: Draw::new(9) };
    let folder = Folder::empty();
    folder.write("robot.toml", &described());
    folder.write("data.csv", &eye.images_of(40, 8e-5));
    if cfg!(feature = "slow") {
        let words = "discover --robot robot.toml --data data.csv --out d.json --json";
        let found = folder.run(words).ended(0).json();
        assert_eq!((&found["rows"], &found["visits"]), (&1920.into(), &40.into()));
        assert_eq!(found["effects"].as_array().unwrap().len(), 0, "{:#}", found["effects"]);
        assert!(found["dependence"].is_null(), "{:#}", found["dependence"]);
        assert_eq!(found["verdict"], "undecided", "{:#}", found["verdict"]);
    }
    let words = "identify --robot robot.toml --data data.csv --json";
    let found = folder.run(words).ended(0).json();
    let sd = kind(&found, "pixel")["sd"].as_f64().unwrap();
    assert!((sd / NOISE).ln().abs() < 0.3, "{sd}");
    assert!(found["noise"]["visit_sd_mm"].as_f64().unwrap() > 0.02, "{:#}", found["noise"]);
    // What is open of a measured number is open along it, not of the place of a tool that the camera hides.
    let budget = found["budget"]["contributions"].as_array().unwrap();
    let model = budget.iter().find(|line| line["source"] == "model parameters").unwrap();
    assert!(model["total_mm"].as_f64().unwrap() < 0.1, "{model:#}");
}

#[test]
fn what_is_wrong_with_a_camera_on_the_flange_is_told_where_it_stands() {
    let (arm, offsets) = Arm::real(13);
    let mut eye = Eye { arm, offsets, draw: Draw::new(4) };
    let (data, robot) = (eye.images(6), described());
    let first: Vec<&str> = data.lines().nth(1).unwrap().split(',').collect();
    let two: String = data.lines().take(1 + 2 * 24).map(|line| format!("{line}\n")).collect();
    let plain = |from: &str, to: &str| robot.replacen(from, to, 1);
    for (robot, table, words) in [
        (
            robot.clone(),
            data.replacen("eye,c0", "eye,", 1),
            "line 2: a camera on the robot needs the point that it saw",
        ),
        (
            robot.clone(),
            data.replacen("point,", "note,", 1),
            "line 2: a camera on the robot needs the point that it saw",
        ),
        (robot.clone(), data.replacen("eye,c0", "eye,c99", 1), "the robot file has no landmark `c99`"),
        (
            robot.clone(),
            data.replacen(first[3], "1300.5", 1),
            "data.csv:2: column `u[px]`: 1300.5 is outside of the image",
        ),
        (
            robot.clone(),
            two,
            "landmark eye: where camera and base are is not determined: three images of four known points",
        ),
        (
            plain("mount = \"tool\"", "mount = \"j3\""),
            data.clone(),
            "`mount = \"j3\"`: a camera is carried by a tool",
        ),
        (
            plain("name = \"c0\"\nxyz = [0, 0, 0]", "name = \"c0\""),
            data.clone(),
            "declare `xyz` of landmark c0",
        ),
        (
            plain("mount = \"tool\"\n", ""),
            data.clone(),
            "line 2: `point` is c0, but what observed it is not on the robot",
        ),
    ] {
        let folder = Folder::empty();
        folder.write("robot.toml", &robot);
        folder.write("data.csv", &table);
        let run = folder.run("identify --robot robot.toml --data data.csv --out fit.json");
        let log = run.ended(INPUT).log;
        assert!(log.contains(words), "{words}\n{log}");
    }
}

/// Images of a board of known place by a camera whose focal lengths are 909 px, not the 900 px of its description, on an arm with these errors, mm
/// and mrad.
pub fn of_another_lens(seed: u64, [position, angle]: [f64; 2], images: usize) -> Folder {
    let folder = Folder::empty();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/10_hand_eye/robot.toml");
    let robot = std::fs::read_to_string(example).unwrap();
    folder.write("robot.toml", &robot.replace("known = false", "xyz = [-550, -150, -30]"));
    let corners: String = (1..13).map(|k| format!("[[landmarks]]\nname = \"c{k}\"\nrows = 0\n")).collect();
    let plant = format!(
        "robot = \"robot.toml\"\nseed = {seed}\n[campaign]\nvisits = 0\nshuffled = true\n\
         [errors.geometric]\nposition_mm = {position}\nangle_mrad = {angle}\n\
         [[cameras]]\nname = \"eye\"\nimages = {images}\nxyz_mm = [40, -50, 60]\nrpy_deg = [1.7, -1.1, 34]\n\
         distance_mm = [250, 500]\nnormal = [0, 0, 1]\nsd_px = 0.1\nfx = 909\nfy = 909\n"
    );
    folder.write("plant.toml", &(plant + &corners));
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    folder
}

/// With so wide a lens error the errors of the arm are estimated as large, and tool and camera turn against each other by degrees from one
/// linearisation to the next: the straight lines of the last one have residuals of 0.1 px, the robot that is written has 29.
#[test]
fn images_whose_rounds_do_not_end_hold_the_arm_and_blame_the_lens() {
    let folder = of_another_lens(103, [0.4, 1.0], 60);
    let run = folder.run("identify --robot robot.toml --data data.csv --json").ended(0);
    assert!(run.log.contains("do not end with the arm's errors free"), "{}", run.log);
    let found = run.json();
    let sensors = &found["kinds"]["sensors"][0];
    let yaw = sensors["values"].as_array().unwrap().iter().find(|value| value[0] == "yaw").unwrap();
    assert!((yaw[1].as_f64().unwrap() - 34.0).abs() < 0.2, "{yaw}");
    assert!(found["kinds"]["kinds"][0]["after"].as_f64().unwrap() > 0.3, "{}", found["kinds"]);
    let suspect = &found["kinds"]["suspects"][0];
    assert_eq!(suspect["what"], "lens", "{suspect}");
    assert!((suspect["values"][0][1].as_f64().unwrap() - 9.0).abs() < 0.6, "{suspect}");
}
