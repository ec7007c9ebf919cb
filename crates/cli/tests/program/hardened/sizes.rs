//! Sizes are worked out before anything is allocated: what no machine has room or time for is refused with its size.

use crate::folder::Folder;
use std::process::Command;
use std::time::{Duration, Instant};

/// No refusal takes longer; most take milliseconds.
const SECONDS: u64 = 10;

fn numbers(count: usize) -> String {
    (1..=count).map(|k| format!("{k},")).collect()
}

#[test]
fn a_model_too_large_for_any_memory_is_refused_with_its_count_and_its_memory() {
    let folder = Folder::with_data();
    let effect = |text: &str| format!("[[effects]]\nfamily = {text}\n");
    let series = |factors: &str| {
        effect(&format!("\"expansion\"\nat = {{ motion = {{ joint = \"j1\" }} }}\nfactors = [{factors}]"))
    };
    let spline = |pieces: usize| {
        format!(
            "{{ of = {{ joint = \"j1\" }}, basis = {{ spline = {{ lower = -3, upper = 3, pieces = {pieces}, degree = 3 }} }} }},"
        )
    };
    let cases = [
        (
            effect(&format!("\"transmission\"\njoint = \"j1\"\nharmonics = [{}]", numbers(10_000))),
            "effect `transmission` has 20000 unknowns, whose fit would take 28.8 GB; at most 4096",
        ),
        (
            series(&spline(313).repeat(2)),
            "effect `expansion` has 99856 unknowns, whose fit would take 717.9 GB; at most 4096",
        ),
        (series(&spline(313).repeat(40)), "effect `expansion` has "),
        (series(&spline(10_000)), "effect `expansion` has 10003 unknowns, "),
        (series(&spline(usize::MAX >> 1)), "effect `expansion` has "),
        (
            series(&spline(2000)) + &series(&spline(2001)) + &series(&spline(2002)),
            "the model has 6012 unknowns, ",
        ),
        (effect("\"geometric\"").repeat(5000), "declares 5000 effects; a model has at most 4096 unknowns"),
    ];
    for (model, words) in cases {
        folder.write("model.toml", &model);
        let began = Instant::now();
        let run = folder
            .run(&["identify", "--robot", "robot.toml", "--data", "data.csv", "--model", "model.toml"])
            .ended(2);
        assert!(run.log.contains(words) && run.log.lines().count() == 1, "{}", run.log);
        assert!(began.elapsed() < Duration::from_secs(SECONDS), "{words}: {:?}", began.elapsed());
    }
}

#[test]
fn little_address_space_is_no_abort() {
    let folder = Folder::with_data();
    // More than there is: unknowns by the thousand.
    let spline = "basis = { spline = { lower = -3, upper = 3, pieces = 3000, degree = 3 } }";
    folder.write(
        "model.toml",
        &format!("[[effects]]\nfamily = \"expansion\"\nat = {{ motion = {{ joint = \"j1\" }} }}\nfactors = [{{ of = {{ joint = \"j1\" }}, {spline} }}]\n"),
    );
    let run = |kilobytes: u64, more: &[&str]| {
        let output = Command::new("sh")
            .current_dir(folder.path())
            .args([
                "-c",
                &format!("ulimit -v {kilobytes}; exec \"$0\" \"$@\""),
                env!("CARGO_BIN_EXE_truepose"),
            ])
            .args([
                "identify",
                "--robot",
                "robot.toml",
                "--data",
                "data.csv",
                "--out",
                "fit.json",
                "--threads",
            ])
            .args(more)
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    for kilobytes in [50_000, 100_000, 200_000, 400_000] {
        let (code, log) = run(kilobytes, &["2"]);
        assert_eq!(code, Some(2), "{kilobytes}: {log}");
        assert!(
            log.starts_with("error: the address space is limited to ") && log.lines().count() == 1,
            "{log}"
        );
    }
    assert_eq!(run(800_000, &["1"]).0, Some(0));
    std::fs::remove_file(folder.file("fit.json")).unwrap();
    let before = folder.names();
    let (code, log) = run(700_000, &["1", "--model", "model.toml"]);
    assert_eq!(code, Some(3), "{log}");
    assert!(log.contains("the address space that the system grants was used up (ulimit -v)"), "{log}");
    assert_eq!(folder.names(), before);
}

/// What fits into memory ends: two thousand pieces of a spline once took minutes for each round.
#[test]
fn two_thousand_pieces_are_no_hang() {
    let folder = Folder::with_data();
    let spline = "basis = { spline = { lower = -3, upper = 3, pieces = 2000, degree = 3 } }";
    folder.write(
        "model.toml",
        &format!("[[effects]]\nfamily = \"expansion\"\nat = {{ motion = {{ joint = \"j1\" }} }}\nfactors = [{{ of = {{ joint = \"j1\" }}, {spline} }}]\n"),
    );
    let run = "identify --robot robot.toml --data data.csv --folds 0 --model model.toml --time-limit 300s";
    folder.run(&run.split(' ').collect::<Vec<_>>()).ended(0);
}

/// Not one by one, for minutes: a table of measurements cannot have them either.
#[test]
fn a_fit_with_a_hundred_thousand_channels_is_refused() {
    let folder = Folder::with_data();
    let fit = "identify --robot robot.toml --data data.csv --folds 0 --out fit.json";
    folder.run(&fit.split(' ').collect::<Vec<_>>()).ended(0);
    let mut fit: serde_json::Value = serde_json::from_str(&folder.read("fit.json")).unwrap();
    let channel = |k| serde_json::json!({"name": format!("c{k}"), "unit": "1", "temperature": false});
    fit["channels"] = (0..100_000).map(channel).collect();
    folder.write("fit.json", &fit.to_string());
    let plan = "plan --fit fit.json --count 2 --pool 8 --out plan.csv --time-limit 60s";
    let run = folder.run(&plan.split(' ').collect::<Vec<_>>()).ended(2);
    assert!(
        run.log.contains("`channels` has more channels than a table of measurements has columns (4096)"),
        "{}",
        run.log
    );
    assert!(!folder.file("plan.csv").exists());
}
