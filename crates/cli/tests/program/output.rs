//! What people read: help, tables and verdicts, with numbers rounded so that they are the same on every platform.

use crate::folder::Folder;
use std::path::{Path, PathBuf};

pub fn example(file: &str) -> String {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/01_identify");
    folder.join(file).canonicalize().unwrap().to_string_lossy().into_owned()
}

/// Paths of the examples lose the folder of this machine.
fn steady() -> insta::Settings {
    let mut settings = insta::Settings::clone_current();
    settings.add_filter(r"(/[^\s/:]+)+/(examples/)", "$2");
    settings
}

#[test]
fn help() {
    let folder = Folder::empty();
    let mut text = folder.run("--help").ended(0).out;
    let commands = text.split_once("Commands:\n").unwrap().1.split_once("\n\n").unwrap().0.to_string();
    let verbs: Vec<&str> = commands.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(verbs.len() > 5, "{verbs:?}");
    for verb in verbs.into_iter().filter(|verb| *verb != "help") {
        text += &format!("\n──── truepose {verb} --help\n\n{}", folder.run(&[verb, "--help"]).ended(0).out);
    }
    insta::assert_snapshot!(text);
}

#[test]
fn version() {
    let out = Folder::empty().run("--version").ended(0).out;
    assert_eq!(out, format!("truepose {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn effects_and_solvers() {
    let folder = Folder::empty();
    let text = folder.run("effects").ended(0).out;
    insta::assert_snapshot!(text);
    let json = folder.run("effects --json").ended(0).json();
    for word in ["geometric", "joint_compliance"] {
        let families = json["effects"].as_array().unwrap();
        assert!(families.iter().any(|e| e["family"] == word), "{word}");
    }
    for word in ["qr", "svd", "normal"] {
        assert!(json["solvers"].as_array().unwrap().iter().any(|s| s["name"] == word), "{word}");
    }
}

#[test]
fn check_lists_the_contents_of_files() {
    let run = Folder::empty()
        .run(&[
            "check",
            "--robot",
            &example("robot.toml"),
            "--data",
            &example("measurements.csv"),
            "--model",
            &example("model.toml"),
        ])
        .ended(0);
    assert_eq!(run.log, "");
    steady().bind(|| insta::assert_snapshot!(run.out));
}

#[test]
fn identify_reports_verdict_figures_and_groups() {
    let run = Folder::empty()
        .run(&[
            "identify",
            "--robot",
            &example("robot.toml"),
            "--data",
            &example("measurements.csv"),
            "--model",
            &example("model.toml"),
        ])
        .ended(0);
    // Nothing but the next command, as it has to be typed.
    let files = ["robot.toml", "measurements.csv", "model.toml"].map(example);
    let next = format!(
        "next, to find it: truepose discover --robot {} --data {} --model {} --out discovered.json --report report (with the same options \
         for reading)\n",
        files[0], files[1], files[2]
    );
    assert_eq!(run.log, next);
    // Two digits behind the point are enough to read, and do not depend on the platform.
    let mut settings = steady();
    settings.add_filter(r"(\d\.\d\d)\d+", "$1…");
    settings.bind(|| insta::assert_snapshot!(run.out));
}

#[test]
fn identify_on_the_example_reaches_its_figures() {
    let run = Folder::empty()
        .run(&[
            "identify",
            "--robot",
            &example("robot.toml"),
            "--data",
            &example("measurements.csv"),
            "--model",
            &example("model.toml"),
            "--json",
        ])
        .ended(0);
    let json = run.json();
    let rms = |stage: usize, data: &str| json["stages"][stage][data]["rms_mm"].as_f64().unwrap() * 1e3;
    let last = json["stages"].as_array().unwrap().len() - 1;
    // The gear that nobody declared has an amplitude of 0.12 mrad: at some 1.5 m from the first axis this is 0.13 mm
    // RMS, on top of which stand 0.05 mm of noise. Without it the fit would be wrong, below it would see the held-out data.
    let (before, after) = (rms(0, "train"), rms(last, "held_out"));
    assert!(before > 2000.0, "{before} µm");
    assert!((50.0..250.0).contains(&after), "{after} µm");
    assert!(rms(last, "train") < after);
}

#[test]
fn a_criterion_that_is_not_met_ends_with_1() {
    let folder = Folder::with_data();
    let identify = |require: &str| {
        folder.run(&[
            "identify",
            "--robot",
            "robot.toml",
            "--data",
            "data.csv",
            "--out",
            "fit.json",
            "--require",
            require,
        ])
    };
    // The instrument's 20 µm an axis are 35 µm in space: 1 µm is out of reach, 0.1 mm is not.
    let failed = identify("1um").ended(1);
    assert!(failed.log.contains("not met: RMS "), "{}", failed.log);
    assert!(failed.log.contains("is above the required "), "{}", failed.log);
    assert!(!failed.out.is_empty(), "the table is printed all the same");
    assert!(folder.file("fit.json").exists(), "the fit is what it is: it is written all the same");
    for met in ["0.1mm", "100um", "1e-4m", "0.004in"] {
        identify(met).ended(0);
    }
}

/// Every example of `truepose effects FAMILY` is a model that can be read, on a robot that has its joints.
#[test]
fn examples_of_effects_are_read() {
    let joint = |name: &str, kind: &str| {
        format!("[[joints]]\nname = \"{name}\"\ntype = \"{kind}\"\nlimits = [-2.0, 2.0]\n")
    };
    let arm: String = (1..=6)
        .map(|k| joint(&format!("j{k}"), "revolute") + "dh = { theta = 0, d = 0.3, a = 0.4, alpha = 1.5 }\n")
        .collect();
    let slide =
        joint("rail", "prismatic") + "origin = { xyz = [0, 0, 0], rpy = [0, 0, 0], axis = [1, 0, 0] }\n";
    let robot = format!("name = \"r\"\n[units]\nlength = \"m\"\nangle = \"rad\"\n{slide}{arm}");
    let folder = tempfile::tempdir().unwrap();
    let robot_file = folder.path().join("robot.toml");
    std::fs::write(&robot_file, robot).unwrap();
    let (chain, _) = truepose_io::read_robot(&robot_file, &truepose_io::RobotOptions::default()).unwrap();
    let registry = truepose_errormodel::EffectRegistry::builtin();
    let mut read = 0;
    for (family, _) in registry.kinds() {
        let text = truepose_report::explanation(family).unwrap().text;
        let Some((_, rest)) = text.split_once("```toml\n") else { continue };
        let model = rest.split("```").next().unwrap();
        let file = folder.path().join(format!("{family}.toml"));
        std::fs::write(&file, model).unwrap();
        let effects =
            truepose_io::read_model(&file, &chain, &registry).unwrap_or_else(|e| panic!("{family}: {e}"));
        assert!(effects.iter().all(|effect| effect.kind() == family), "{family}");
        read += 1;
    }
    assert_eq!(read, 15, "landmarks and sessions come from the data");
}
