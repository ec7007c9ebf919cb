//! The program of this example, run as a user would.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use assert_cmd::Command;
use std::path::Path;

fn run(arguments: &[&str], folder: &Path) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_acme-truepose"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn own_effects_and_solvers_are_used() {
    let folder = tempfile::tempdir().unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../01_identify");
    let file = |name: &str| example.join(name).display().to_string();
    let (code, listed, _) = run(&["effects"], folder.path());
    assert_eq!(code, Some(0));
    assert!(listed.contains("acme/encoder_gain") && listed.contains("acme/descent"), "{listed}");
    std::fs::write(
        folder.path().join("model.toml"),
        "[[effects]]\nfamily = \"geometric\"\n[[effects]]\nfamily = \"acme/encoder_gain\"\njoint = \"a2\"\n",
    )
    .unwrap();
    let (robot, data) = (file("robot.toml"), file("measurements.csv"));
    let files =
        ["identify", "--robot", &robot, "--data", &data, "--model", "model.toml", "--out", "fit.json"];
    let (code, said, log) = run(&[&files[..], &["--folds", "0"]].concat(), folder.path());
    assert_eq!(code, Some(0), "{log}");
    assert!(said.contains("gain a2"), "{said}");
    // The fit is read again with the effect that only this program knows.
    let predict = ["predict", "--fit", "fit.json", "--data", &data, "--out", "p.csv"];
    assert_eq!(run(&predict, folder.path()).0, Some(0));
    let solver = ["--folds", "0", "--solver", "acme/descent", "--prior", "none", "--rounds", "1"];
    let (code, said, log) = run(&[&files[..], &solver].concat(), folder.path());
    assert_eq!(code, Some(0), "{said}{log}");
    let fit = std::fs::read_to_string(folder.path().join("fit.json")).unwrap();
    assert!(fit.contains("\"acme/descent\""));
    let (code, _, log) = run(&[&files[..], &["--solver", "acme/descend"]].concat(), folder.path());
    assert_eq!(code, Some(2));
    assert!(log.contains("acme/descend"), "{log}");
}
