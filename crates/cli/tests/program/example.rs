//! The commands that the documents show are run, as they stand there.

use crate::folder::{Folder, Run};
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// A folder with the examples in it, so that what a command writes goes nowhere else.
fn copied() -> Folder {
    let folder = Folder::empty();
    for entry in std::fs::read_dir(root().join("examples")).unwrap() {
        let from = entry.unwrap().path();
        let to = folder.path().join("examples").join(from.file_name().unwrap());
        std::fs::create_dir_all(&to).unwrap();
        for file in std::fs::read_dir(&from).unwrap().map(|entry| entry.unwrap().path()) {
            if file.is_file() {
                std::fs::copy(&file, to.join(file.file_name().unwrap())).unwrap();
            }
        }
    }
    folder
}

/// Arguments of every `truepose …` line in the fenced blocks of a document; a line may end in a backslash.
fn commands(document: &str) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    // Lines of a file are no commands.
    for block in document.split("```").skip(1).step_by(2).filter(|block| !block.starts_with("toml")) {
        let joined = block.replace("\\\n", " ");
        for line in joined.lines().map(|line| line.trim().trim_start_matches("$ ")) {
            let line = line.split(" #").next().unwrap_or(line);
            let program = line.split_once("truepose-cli -- ").map(|(_, rest)| rest);
            let arguments = line.strip_prefix("truepose ").or(program);
            if let Some(arguments) = arguments {
                found.push(arguments.split_whitespace().map(str::to_string).collect());
            }
        }
    }
    found
}

fn run(folder: &Folder, arguments: &[String]) -> Run {
    folder.run(&arguments.iter().map(String::as_str).collect::<Vec<_>>())
}

#[test]
fn the_first_example() {
    let folder = copied();
    let at = |file: &str| format!("examples/01_identify/{file}");
    let (robot, data, model) = (at("robot.toml"), at("measurements.csv"), at("model.toml"));
    folder.run(&["check", "--robot", &robot, "--data", &data, "--model", &model]).ended(0);
    let identify = ["identify", "--robot", &robot, "--data", &data, "--model", &model, "--out", "fit.json"];
    let said = folder.run(&identify).ended(0).out;
    assert!(said.contains("Position error (3-D RMS) on held-out configurations: "), "{said}");
    folder.run(&["predict", "--fit", "fit.json", "--data", &data, "--out", "predicted.csv"]).ended(0);
    assert_eq!(folder.read("predicted.csv").lines().count(), folder.read(&data).lines().count());
}

#[test]
fn data_of_the_examples_are_what_their_plants_measure() {
    let folder = copied();
    for example in ["01_identify", "02_measured_robot", "03_unexplained"] {
        let at = |file: &str| format!("examples/{example}/{file}");
        folder.run(&["simulate", "--plant", &at("plant.toml"), "--out", "again.csv"]).ended(0);
        let numbers = |text: &str| -> Vec<f64> {
            text.split([',', '\n']).filter_map(|cell| cell.parse().ok()).collect()
        };
        let (shipped, again) = (folder.read(&at("measurements.csv")), folder.read("again.csv"));
        assert!(shipped.len() < 300_000, "{example}: {} bytes", shipped.len());
        assert_eq!(shipped.lines().next(), again.lines().next());
        let (shipped, again) = (numbers(&shipped), numbers(&again));
        assert_eq!(shipped.len(), again.len());
        // mm and degrees; mathematical libraries of platforms differ in the last bits.
        let worst = shipped.iter().zip(&again).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-9, "{example}: {worst}");
    }
}

/// A discovery of an example as JSON.
fn discovered(example: &str) -> serde_json::Value {
    let folder = copied();
    let at = |file: &str| format!("examples/{example}/{file}");
    let (robot, data) = (at("robot.toml"), at("measurements.csv"));
    let ran =
        folder.run(&["discover", "--robot", &robot, "--data", &data, "--out", "fit.json", "--json"]).ended(0);
    ran.json()
}

#[cfg(feature = "slow")]
#[test]
fn the_measured_robot_is_explained_down_to_its_repeatability() {
    let found = discovered("02_measured_robot");
    let effects: Vec<(&str, &str)> = found["effects"]
        .as_array()
        .unwrap()
        .iter()
        .map(|effect| (effect["family"].as_str().unwrap(), effect["joint"].as_str().unwrap()))
        .collect();
    assert_eq!(effects, [("joint_compliance", "j2"), ("transmission", "j1")]);
    assert_eq!(found["verdict"], "adequate");
    // µrad/(N·m); what was put in, within three times its 95 % interval.
    let size = &found["effects"][0]["parameters"][0];
    let value = size["value"].as_f64().unwrap();
    assert!((value - 1e6 / 4.5e5 * if value < 1e-3 { 1e-6 } else { 1.0 }).abs() < 0.05 * value, "{size}");
    let rms = |part: &str| found[part]["holdout"]["rms_mm"].as_f64().unwrap();
    assert!(rms("after") < 0.2 * rms("before"), "{} {}", rms("before"), rms("after"));
}

/// An identification of an example as JSON.
fn identified(example: &str) -> serde_json::Value {
    let folder = copied();
    let at = |file: &str| format!("examples/{example}/{file}");
    let (robot, data) = (at("robot.toml"), at("measurements.csv"));
    folder.run(&["identify", "--robot", &robot, "--data", &data, "--json"]).ended(0).json()
}

/// Their data is from a script that shares nothing with this workspace; the sizes are those that it puts in.
#[test]
fn arms_without_a_tracker() {
    let sockets = identified("09_sockets");
    let spread = sockets["landmarks"]["held_out"]["rms_mm"].as_f64().unwrap();
    assert!((0.1..0.2).contains(&spread), "{spread}");
    assert!(sockets["landmarks"]["distance_rms_mm"].as_f64().unwrap() < 0.04, "{sockets}");
    let camera = identified("10_hand_eye");
    let pixel = &camera["kinds"]["kinds"][0];
    assert!(pixel["before"].as_f64().unwrap() > 1.0 && pixel["held_out"].as_f64().unwrap() < 0.17, "{pixel}");
    let place = &camera["kinds"]["sensors"][0];
    for (k, truth) in [40.0, -50.0, 60.0].into_iter().enumerate() {
        let (value, within) = (&place["values"][k][1], &place["within_95"][k][1]);
        let off = (value.as_f64().unwrap() - truth).abs();
        assert!(off < 1.5 * within.as_f64().unwrap(), "{value} ± {within}, not {truth}");
    }
    assert_eq!(camera["kinds"]["suspects"], serde_json::json!([]));

    let arms = identified("11_two_arms");
    let gap = arms["landmarks"]["contacts"][0]["held_out"]["rms_mm"].as_f64().unwrap();
    assert!(gap < 1.25 * 0.02 * 3f64.sqrt(), "{gap}");
    assert_eq!(arms["landmarks"]["scale_known"], true);
}

#[cfg(feature = "slow")]
#[test]
fn the_gear_of_an_arm_in_sockets_is_found() {
    let found = discovered("09_sockets");
    assert_eq!(
        (&found["effects"][0]["family"], &found["effects"][0]["joint"]),
        (&"transmission".into(), &"j2".into())
    );
    assert_eq!(found["effects"].as_array().unwrap().len(), 1);
    // 0.02 mm an axis.
    let after = found["after"]["holdout"]["rms_mm"].as_f64().unwrap();
    assert!(after < 1.25 * 0.02 * 3f64.sqrt(), "{after}");
}

#[test]
fn a_camera_that_no_image_agrees_with_is_refused() {
    let folder = copied();
    let robot = folder.read("examples/10_hand_eye/robot.toml").replace("cx = 640", "cx = 64000");
    folder.write("robot.toml", &robot);
    let data = "examples/10_hand_eye/measurements.csv";
    let log = folder.run(&["identify", "--robot", "robot.toml", "--data", data]).ended(2).log;
    assert!(log.contains("eye: in 36 of 36 images: no place of the camera explains its pixels"), "{log}");
    assert!(!log.contains("--map \"target=point\""), "{log}");
}

/// Numbers with two significant digits: platforms differ in the last ones, and the text is what is compared.
fn rounded(value: &serde_json::Value) -> serde_json::Value {
    use serde_json::Value;
    match value {
        Value::Number(number) if number.as_i64().is_none() => {
            let short: f64 = format!("{:.1e}", number.as_f64().unwrap()).parse().unwrap();
            serde_json::json!(short)
        }
        Value::Array(list) => list.iter().map(rounded).collect(),
        Value::Object(map) => map.iter().map(|(key, value)| (key.clone(), rounded(value))).collect(),
        other => other.clone(),
    }
}

#[cfg(feature = "slow")]
#[test]
fn a_discovery_and_its_story() {
    let folder = copied();
    let at = |file: &str| format!("examples/02_measured_robot/{file}");
    let (robot, data) = (at("robot.toml"), at("measurements.csv"));
    let text =
        folder.run(&["discover", "--robot", &robot, "--data", &data, "--report", "report"]).ended(0).out;
    let mut settings = insta::Settings::clone_current();
    // Numbers of the text, but for whole ones.
    settings.add_filter(r"\d+\.\d+(e-?\d+)?", "[number]");
    settings.add_filter("█+", "[bar]");
    settings.bind(|| insta::assert_snapshot!("story", text));
    let mut found = folder.json("report/discovery.json");
    // Long, and tested where it is the subject.
    assert!(found.as_object_mut().unwrap().remove("parameters").is_some());
    insta::assert_snapshot!("discovery_json", serde_json::to_string_pretty(&rounded(&found)).unwrap());
}

#[cfg(feature = "slow")]
#[test]
fn an_error_without_a_word_ends_in_an_unexplained_verdict() {
    let found = discovered("03_unexplained");
    assert_eq!(found["verdict"], "unexplained");
    assert_eq!(found["effects"].as_array().unwrap().len(), 0, "{}", found["effects"]);
    assert_eq!(found["before"]["holdout"], found["after"]["holdout"]);
    assert!(found["lack_of_fit"]["after"].as_f64().unwrap() < 1e-6);
    let share = found["unexplained"]["share_of_variance"].as_f64().unwrap();
    assert!(share > 0.8, "{share}");
}

#[test]
fn commands_of_the_documents_run() {
    let folder = copied();
    let mut documents: Vec<PathBuf> = vec![root().join("README.md")];
    for entry in std::fs::read_dir(root().join("examples")).unwrap() {
        documents.push(entry.unwrap().path().join("README.md"));
    }
    documents.sort();
    // What these show, in other languages than the shell's, is run by their own tests.
    let foreign = ["04_downstream", "05_own_program", "07_python", "08_notebooks"];
    let own = |path: &Path| foreign.iter().any(|name| path.ends_with(name));
    let run_here = |path: &&PathBuf| path.exists() && !own(path.parent().unwrap());
    let mut done = std::collections::HashSet::new();
    for document in documents.iter().filter(run_here) {
        let text = std::fs::read_to_string(document).unwrap();
        // `D/` stands for any folder of the reader's own.
        let shown = commands(&text);
        let of_examples = shown.iter().filter(|command| !command.iter().any(|word| word.starts_with("D/")));
        let mut ran = 0;
        for command in of_examples {
            ran += 1;
            // Its files are there: all documents are of one folder.
            if !done.insert(command.clone()) {
                continue;
            }
            println!("{}: truepose {}", document.display(), command.join(" "));
            let mut command = command.clone();
            // The golden corpus has whole searches; here options, files and outputs are what is tested.
            if command[0] == "discover" && !cfg!(feature = "slow") {
                command.extend(["--most", "0", "--rotations", "99"].map(String::from));
                command.retain(|word| word != "--nested");
            }
            run(&folder, &command).ended(0);
        }
        assert!(ran > 0, "{} shows no command that can be run", document.display());
    }
}

#[test]
fn commands_are_found_in_a_document() {
    let text = "Say\n\n```sh\n$ truepose identify --robot r.toml \\\n    --data d.csv   # fits\ncargo run -q -p truepose-cli -- effects\n```\n";
    assert_eq!(commands(text), [vec!["identify", "--robot", "r.toml", "--data", "d.csv"], vec!["effects"]]);
}
