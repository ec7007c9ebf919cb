//! Fifteen mistakes of convention, each made by editing a right robot file or a right table as text, on three robots: `check` names each.

use crate::folder::Folder;

/// An arm of six joints with elbow and wrist offsets, in standard DH.
const ELBOW: &str = r#"name = "elbow"

[units]
length = "mm"
angle = "deg"

[[joints]]
name = "j1"
limits = [-80, 80]
dh = { theta = 0, d = 400, a = 150, alpha = -90 }

[[joints]]
name = "j2"
limits = [-80, 60]
dh = { theta = -90, d = 0, a = 600, alpha = 0 }

[[joints]]
name = "j3"
limits = [-70, 70]
dh = { theta = 0, d = 20, a = 120, alpha = -90 }

[[joints]]
name = "j4"
limits = [-80, 80]
dh = { theta = 0, d = 620, a = 0, alpha = 90 }

[[joints]]
name = "j5"
limits = [-80, 80]
dh = { theta = 0, d = 0, a = 30, alpha = -90 }

[[joints]]
name = "j6"
limits = [-80, 80]
dh = { theta = 0, d = 100, a = 0, alpha = 0 }
"#;

const INSTALLED: &str = "
[base]
xyz = [1800, -700, 300]
rpy = [2, -3, 70]

[tool]
xyz = [60, 25, 140]
rpy = [10, 40, -20]
";

const PLANT: &str = r#"robot = "robot.toml"
seed = 3

[errors.geometric]
position_mm = 0.1
angle_mrad = 0.1

[instrument]
sd_um = 20
orientation_urad = 50

[campaign]
postures = "random"
visits = 60
"#;

/// A robot of the program's library without its open installation, and with this one.
fn installed(name: &str) -> String {
    let folder = Folder::empty();
    folder.run(&["init", name, "--out", "r.toml"]).ended(0);
    let text = folder.read("r.toml");
    format!("{}{INSTALLED}", text.split("\n# Where the robot stands").next().unwrap())
}

/// A table: names, units, and rows of numbers (or none where a cell is empty).
#[derive(Clone)]
struct Table {
    header: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn read(text: &str) -> Table {
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let header = lines.next().unwrap();
        let number = |cell: &String| cell.parse().unwrap_or(f64::NAN);
        Table { header, rows: lines.map(|row| row.iter().map(number).collect()).collect() }
    }

    fn text(&self) -> String {
        let row = |row: &Vec<f64>| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n";
        self.header.join(",") + "\n" + &self.rows.iter().map(row).collect::<String>()
    }

    fn column(&self, name: &str) -> usize {
        self.header.iter().position(|header| header.split('[').next() == Some(name)).unwrap()
    }

    /// With every row changed in these columns.
    fn with<const N: usize>(mut self, names: [&str; N], change: impl Fn([f64; N]) -> [f64; N]) -> Self {
        let columns = names.map(|name| self.column(name));
        for row in &mut self.rows {
            let values = change(columns.map(|k| row[k]));
            columns.into_iter().zip(values).for_each(|(k, value)| row[k] = value);
        }
        self
    }

    /// The orientations as three numbers that are called so.
    fn turned(mut self, names: [&str; 3], angles: impl Fn(&Rotation) -> [f64; 3]) -> Self {
        let columns = ["qw", "qx", "qy", "qz"].map(|name| self.column(name));
        for row in &mut self.rows {
            let found = angles(&rotation(columns.map(|k| row[k])));
            row.remove(columns[3]);
            columns.into_iter().zip(found).for_each(|(k, value)| row[k] = value);
        }
        self.header.remove(columns[3]);
        columns.into_iter().zip(names).for_each(|(k, name)| self.header[k] = name.to_owned());
        self
    }
}

type Rotation = [[f64; 3]; 3];

fn rotation([w, x, y, z]: [f64; 4]) -> Rotation {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// Roll, pitch, yaw, degrees.
fn rpy(r: &Rotation) -> [f64; 3] {
    let pitch = (-r[2][0]).clamp(-1.0, 1.0).asin();
    [r[2][1].atan2(r[2][2]), pitch, r[1][0].atan2(r[0][0])].map(f64::to_degrees)
}

/// The rotation vector, degrees.
fn vector(r: &Rotation) -> [f64; 3] {
    let cosine = ((r[0][0] + r[1][1] + r[2][2] - 1.0) / 2.0).clamp(-1.0, 1.0);
    let angle = cosine.acos();
    let axis = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]];
    axis.map(|v| (v * angle / (2.0 * angle.sin())).to_degrees())
}

/// A robot, right in every respect, and its measurements.
struct Right {
    name: &'static str,
    folder: Folder,
    robot: String,
    data: Table,
    joints: Vec<String>,
}

impl Right {
    fn new(name: &'static str, robot: String) -> Right {
        let folder = Folder::empty();
        folder.write("robot.toml", &robot);
        folder.write("plant.toml", PLANT);
        folder.run(&["simulate", "--plant", "plant.toml", "--out", "data.csv"]).ended(0);
        let data = Table::read(&folder.read("data.csv"));
        let named = robot.lines().filter_map(|line| line.strip_prefix("name = ")).skip(1);
        let joints = named.map(|name| name.trim_matches('"').to_owned()).collect();
        Right { name, folder, robot, data, joints }
    }

    /// What `check` says about a robot file and a table.
    fn said(&self, robot: &str, data: &Table, options: &[&str]) -> String {
        self.folder.write("r.toml", robot);
        self.folder.write("d.csv", &data.text());
        self.folder.run(&[&["check", "--robot", "r.toml", "--data", "d.csv"], options].concat()).log
    }

    #[track_caller]
    fn named(&self, mistake: &str, robot: &str, data: &Table, words: &[&str]) {
        assert!(robot != self.robot || data.text() != self.data.text(), "{mistake}: nothing was changed");
        let said = self.said(robot, data, &[]);
        assert!(words.iter().any(|words| said.contains(words)), "{}: {mistake}\n{said}", self.name);
    }

    fn joint(&self, number: usize) -> &str {
        &self.joints[number - 1]
    }

    /// Mistakes that can be made on any robot.
    fn of_tables(&self) {
        let Right { robot, data, .. } = self;
        let (second, third, fifth) = (self.joint(2), self.joint(3), self.joint(5));
        let coupled = data.clone().with([second, third], |[driver, joint]| [driver, joint - driver]);
        self.named("J2/J3 coupling", robot, &coupled, &[&format!("{third} seems to be coupled to {second}")]);
        let flipped = data.clone().with([fifth], |[q]| [-q]);
        self.named(
            "direction of a joint",
            robot,
            &flipped,
            &[&format!("{fifth} seems to have the opposite sign")],
        );
        let swapped = data.clone().with([second, third], |[a, b]| [b, a]);
        let words = format!("the columns of {second} and {third} seem swapped");
        self.named("order of joints", robot, &swapped, &[&words]);
        let offset = data.clone().with([second], |[q]| [q + 90.0]);
        self.named("offset of 90°", robot, &offset, &[&format!("the zero of {second} seems")]);
        let metres =
            Table { header: data.header.iter().map(|h| h.replace("[mm]", "[m]")).collect(), ..data.clone() };
        self.named("mm as m", robot, &metres, &["millimetres taken for metres", "check the unit"]);
        let mirrored = data.clone().with(["y"], |[y]| [-y]);
        self.named("left-handed axes", robot, &mirrored, &["y seems to have the wrong sign", "left-handed"]);
        let last = data.clone().with(["qw", "qx", "qy", "qz"], |[w, x, y, z]| [x, y, z, w]);
        self.named("order of the quaternion", robot, &last, &["quaternions seem to have their scalar last"]);
        let names = ["x", "y", "z", "qw", "qx", "qy", "qz"];
        let inverse = data.clone().with(names, |[x, y, z, qw, qx, qy, qz]| {
            let r = rotation([qw, qx, qy, qz]);
            let [x, y, z] = [0, 1, 2].map(|k| -(r[0][k] * x + r[1][k] * y + r[2][k] * z));
            [x, y, z, qw, -qx, -qy, -qz]
        });
        self.named("inverse poses", robot, &inverse, &["positions and orientations seem to be inverse"]);
        let angles = data.clone().turned(["rx[deg]", "ry[deg]", "rz[deg]"], rpy);
        let words = ["read as a rotation vector: try `--orientation rpy`", "try `--orientation wpr`"];
        self.named("angles as a rotation vector", robot, &angles, &words);
        let right = self.said(robot, &angles, &["--orientation", "rpy"]);
        assert!(!right.contains("orientation"), "{right}");
        let other = self.said(robot, &angles, &["--orientation", "xyz"]);
        assert!(
            other.contains("angles of another convention: try `--orientation rpy`"),
            "{}: {other}",
            self.name
        );
        let vectors = data.clone().turned(["rx[deg]", "ry[deg]", "rz[deg]"], vector);
        let said = self.said(robot, &vectors, &["--orientation", "rpy"]);
        let words = "rotation vectors that are read as angles: try `--orientation rotation_vector`";
        assert!(said.contains(words), "{}: {said}", self.name);
        let flipped = robot.replace("xyz = [60, 25, 140]", "xyz = [60, 25, -140]");
        self.named("flipped tool", &flipped, data, &["z of [tool] seems to have the opposite sign"]);
    }

    /// A mistake in the robot file, by replacing a text that is in it once.
    #[track_caller]
    fn of_robot(&self, mistake: &str, (from, to): (&str, &str), words: &[&str]) {
        assert_eq!(self.robot.matches(from).count(), 1, "{from}");
        self.named(mistake, &self.robot.replace(from, to), &self.data, words);
    }
}

#[test]
fn standard_dh() {
    let arm = Right::new("elbow", format!("{ELBOW}{INSTALLED}"));
    let right = arm.said(&arm.robot, &arm.data, &[]);
    assert_eq!(right, "", "nothing is wrong");
    arm.of_tables();
    let other = arm.robot.replace("dh = {", "mdh = {");
    arm.named(
        "mdh for dh",
        &other,
        &arm.data,
        &["the parameters under `mdh` seem to be standard DH parameters"],
    );
    arm.of_robot(
        "degrees as radians",
        ("angle = \"deg\"", "angle = \"rad\""),
        &["set `angle = \"deg\"` in [units]"],
    );
    arm.of_robot(
        "45 mm",
        ("a = 600", "a = 645"),
        &["`a` of j2 seems to be 600", "`a` of j2 seems to be 599"],
    );
    arm.of_robot("sign of a", ("a = 120", "a = -120"), &["`a` of j3 seems to have the opposite sign"]);
}

#[test]
fn modified_dh_and_seven_joints() {
    let arm = Right::new("panda", installed("panda"));
    let right = arm.said(&arm.robot, &arm.data, &[]);
    assert_eq!(right, "", "nothing is wrong");
    arm.of_tables();
    let other = arm.robot.replace("mdh = {", "dh = {");
    arm.named(
        "dh for mdh",
        &other,
        &arm.data,
        &["the parameters under `dh` seem to be modified DH parameters"],
    );
    arm.of_robot(
        "degrees as radians",
        ("angle = \"deg\"", "angle = \"rad\""),
        &["set `angle = \"deg\"` in [units]"],
    );
    arm.of_robot(
        "45 mm",
        ("d = 316", "d = 361"),
        &["`d` of j3 seems to be 316", "`d` of j3 seems to be 315.9"],
    );
    arm.of_robot("sign of a", ("a = 82.5", "a = -82.5 "), &["`a` of j4 seems to have the opposite sign"]);
}

#[test]
fn origins_and_a_coupling() {
    let arm = Right::new("lrmate200id", installed("lrmate200id"));
    let right = arm.said(&arm.robot, &arm.data, &[]);
    assert_eq!(right, "", "nothing is wrong");
    arm.of_tables();
    let coupling = "[[couplings]]\njoint = \"J3\"\ndriver = \"J2\"\nfactor = 1\n";
    arm.of_robot("no coupling", (coupling, ""), &["J3 seems to be coupled to J2"]);
    arm.of_robot(
        "45 mm",
        ("[0, 0, 330]", "[0, 0, 375]"),
        &["`z` of J3 seems to be 330", "`z` of J3 seems to be 329.9"],
    );
    arm.of_robot(
        "sign of a length",
        ("[0, 0, 35]", "[0, 0, -35]"),
        &["`z` of J4 seems to be 35", "`z` of J4 seems to be 34.9"],
    );
}
