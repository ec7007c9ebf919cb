//! Data block by block.

use crate::folder::Folder;
use crate::output::example;

fn identify(more: &[&str]) -> Vec<String> {
    let (robot, data, model) = (example("robot.toml"), example("measurements.csv"), example("model.toml"));
    let words = ["identify", "--robot", &robot, "--data", &data, "--model", &model];
    words.iter().chain(more).map(|word| (*word).to_string()).collect()
}

fn json(more: &[&str]) -> serde_json::Value {
    let words = identify(more);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    Folder::empty().run(&words).ended(0).json()
}

#[test]
fn blocks_find_what_the_whole_finds() {
    let (whole, blocks) = (json(&["--json"]), json(&["--json", "--stream"]));
    assert_eq!(whole["rows"], blocks["rows"]);
    assert_eq!(whole["visits"], blocks["visits"]);
    let last = whole["stages"].as_array().unwrap().last().unwrap();
    let rms = |value: &serde_json::Value| value["rms_mm"].as_f64().unwrap();
    // One may take in a direction that the other leaves: hundredths of the RMS. Folds are drawn differently: a tenth.
    let close = |a: f64, b: f64, share: f64| assert!((a - b).abs() < share * b, "{a} {b}");
    close(rms(&blocks["train"]), rms(&last["train"]), 0.03);
    close(rms(&blocks["held_out"]), rms(&last["held_out"]), 0.15);
    assert_eq!(blocks["fold_rms_mm"].as_array().unwrap().len(), 5);
}

#[test]
fn a_fit_of_blocks_is_a_fit() {
    let folder = Folder::empty();
    let words = identify(&["--stream", "--linear", "--folds", "0", "--out", "fit.json", "--require", "5mm"]);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let run = folder.run(&words).ended(0);
    assert!(run.out.contains("read block by block"), "{}", run.out);
    folder
        .run(&["predict", "--fit", "fit.json", "--data", &example("measurements.csv"), "--out", "p.csv"])
        .ended(0);
}

#[test]
fn what_cannot_be_done_in_blocks_is_reported() {
    let refused = |more: &[&str]| {
        let words = identify(more);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        Folder::empty().run(&words).ended(2).log.clone()
    };
    let log = refused(&["--stream", "--solver", "huber(qr)"]);
    assert!(log.contains("has to see all rows at once; read the data as a whole"), "{log}");
    assert!(refused(&["--stream", "--holdout", "0.2"]).contains("--holdout"));
    assert!(refused(&["--stream", "--folds", "1"]).contains("one fold leaves no data to fit"));
}
