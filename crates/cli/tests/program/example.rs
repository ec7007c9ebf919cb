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
    for block in document.split("```").skip(1).step_by(2) {
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
fn its_data_is_what_its_plant_measures() {
    let folder = copied();
    let plant = "examples/01_identify/plant.toml";
    folder.run(&["simulate", "--plant", plant, "--out", "again.csv"]).ended(0);
    let numbers =
        |text: &str| -> Vec<f64> { text.split([',', '\n']).filter_map(|cell| cell.parse().ok()).collect() };
    let (shipped, again) = (folder.read("examples/01_identify/measurements.csv"), folder.read("again.csv"));
    assert_eq!(shipped.lines().next(), again.lines().next());
    let (shipped, again) = (numbers(&shipped), numbers(&again));
    assert_eq!(shipped.len(), again.len());
    // mm and degrees; mathematical libraries of platforms differ in the last bits.
    let worst = shipped.iter().zip(&again).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-9, "{worst}");
}

#[test]
fn commands_of_the_documents_run() {
    let folder = copied();
    let mut documents: Vec<PathBuf> = vec![root().join("README.md")];
    for entry in std::fs::read_dir(root().join("examples")).unwrap() {
        documents.push(entry.unwrap().path().join("README.md"));
    }
    documents.sort();
    for document in documents.iter().filter(|path| path.exists()) {
        let text = std::fs::read_to_string(document).unwrap();
        // `D/` stands for any folder of the reader's own.
        let shown = commands(&text);
        let of_examples = shown.iter().filter(|command| !command.iter().any(|word| word.starts_with("D/")));
        let mut ran = 0;
        for command in of_examples {
            ran += 1;
            println!("{}: truepose {}", document.display(), command.join(" "));
            run(&folder, command).ended(0);
        }
        assert!(ran > 0, "{} shows no command that can be run", document.display());
    }
}

#[test]
fn commands_are_found_in_a_document() {
    let text = "Say\n\n```sh\n$ truepose identify --robot r.toml \\\n    --data d.csv   # fits\ncargo run -q -p truepose-cli -- effects\n```\n";
    assert_eq!(commands(text), [vec!["identify", "--robot", "r.toml", "--data", "d.csv"], vec!["effects"]]);
}
