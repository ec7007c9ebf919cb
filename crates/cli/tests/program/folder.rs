//! A folder with a small robot in it, and the program run inside that folder.

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use tempfile::TempDir;

/// An arm of two turns and a slide, with two targets, in mm and degrees.
pub const ROBOT: &str = r#"name = "small"

[units]
length = "mm"
angle = "deg"

[[joints]]
name = "j1"
type = "revolute"
limits = [-170, 170]
dh = { theta = 0, d = 300, a = 150, alpha = 90 }

[[joints]]
name = "j2"
type = "revolute"
limits = [-120, 120]
dh = { theta = 0, d = 20, a = 400, alpha = 80 }

[[joints]]
name = "d3"
type = "prismatic"
limits = [0, 250]
dh = { theta = 0, d = 100, a = 0, alpha = 0 }

[[targets]]
name = "T1"
xyz = [50, 0, 30]

[[targets]]
name = "T2"
xyz = [-20, 60, 0]
"#;

const PLANT: &str = r#"robot = "robot.toml"
seed = 3

[errors.geometric]
position_mm = 0.4
angle_mrad = 0.5

[instrument]
sd_um = 20

[campaign]
postures = "random"
visits = 40
"#;

/// A folder that disappears with the test.
pub struct Folder(TempDir);

impl Folder {
    /// An empty one.
    pub fn empty() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }

    /// With `robot.toml`, `plant.toml`, and `data.csv` as that plant was measured: once, for all tests of the process.
    pub fn with_data() -> Self {
        static DATA: LazyLock<String> = LazyLock::new(|| {
            let folder = Folder::with_robot();
            folder.run("simulate --plant plant.toml --out data.csv").ended(0);
            folder.read("data.csv")
        });
        let folder = Folder::with_robot();
        folder.write("data.csv", &DATA);
        folder
    }

    fn with_robot() -> Self {
        let folder = Folder::empty();
        folder.write("robot.toml", ROBOT);
        folder.write("plant.toml", PLANT);
        folder
    }

    /// With `fit.json` of the heavy arm of the first example: identified once, for all tests of the process.
    pub fn with_heavy_fit() -> Self {
        static FIT: LazyLock<String> = LazyLock::new(|| {
            let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/01_identify");
            let [robot, data, model] = ["robot.toml", "measurements.csv", "model.toml"]
                .map(|name| example.join(name).display().to_string());
            let folder = Folder::empty();
            let words =
                ["identify", "--robot", &robot, "--data", &data, "--model", &model, "--out", "fit.json"];
            folder.run(&words).ended(0);
            folder.read("fit.json")
        });
        let folder = Folder::empty();
        folder.write("fit.json", &FIT);
        folder
    }

    /// Another one with the same files.
    pub fn copied(&self) -> Self {
        fn copy(from: &Path, to: &Path) {
            std::fs::create_dir_all(to).unwrap();
            for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
                let (from, to) = (entry.path(), to.join(entry.file_name()));
                if from.is_dir() { copy(&from, &to) } else { assert!(std::fs::copy(from, to).is_ok()) }
            }
        }
        let folder = Folder::empty();
        copy(self.path(), folder.path());
        folder
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.file(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.file(name)).unwrap()
    }

    /// A file of JSON.
    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// Names of all files, hidden ones included, sorted.
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// Runs the program in this folder: with a line as it is typed, or with words that may have blanks in them.
    pub fn run(&self, arguments: impl Arguments) -> Run {
        let arguments = arguments.words();
        let output = Command::new(env!("CARGO_BIN_EXE_truepose"))
            .current_dir(self.path())
            .args(&arguments)
            .output()
            .unwrap();
        Run {
            command: arguments.join(" "),
            code: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            log: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

/// What a run is started with.
pub trait Arguments {
    fn words(&self) -> Vec<&str>;
}

impl Arguments for &str {
    fn words(&self) -> Vec<&str> {
        self.split(' ').collect()
    }
}

impl Arguments for &String {
    fn words(&self) -> Vec<&str> {
        self.split(' ').collect()
    }
}

impl<const N: usize> Arguments for &[&str; N] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl Arguments for &[&str] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl Arguments for &Vec<&str> {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

/// How a run ended and what it said.
pub struct Run {
    pub command: String,
    pub code: Option<i32>,
    pub out: String,
    pub log: String,
}

impl Run {
    /// It ended with this exit code.
    #[track_caller]
    pub fn ended(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "truepose {}\n{}\n{}", self.command, self.out, self.log);
        self
    }

    /// What it printed, as JSON.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap()
    }
}
