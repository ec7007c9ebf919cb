//! The same bytes from 1, 2, 4 and 7 threads and from a second run, of every verb: what is printed, and every file.

use crate::folder::Folder;
use std::collections::BTreeMap;
use std::path::Path;

/// Verbs with what they are run on, and what they write.
const RUNS: &[(&[&str], &[&str])] = &[
    (&["simulate", "--plant", "plant.toml", "--out", "out.csv"], &["out.csv"]),
    (&["check", "--robot", "robot.toml", "--data", "data.csv"], &[]),
    (&["effects"], &[]),
    (
        &[
            "identify",
            "--robot",
            "robot.toml",
            "--data",
            "data.csv",
            "--out",
            "out.json",
            "--report",
            "page",
            "--repeat",
            "3",
        ],
        &["out.json", "page"],
    ),
    (
        &[
            "identify",
            "--robot",
            "robot.toml",
            "--data",
            "data.csv",
            "--holdout",
            "0.2",
            "--solver",
            "tukey(qr)",
            "--json",
        ],
        &[],
    ),
    (
        &[
            "discover",
            "--robot",
            "robot.toml",
            "--data",
            "data.csv",
            "--out",
            "out.json",
            "--report",
            "page",
            "--rotations",
            "99",
            "--nested",
            "2",
        ],
        &["out.json", "page"],
    ),
    (&["predict", "--fit", "fit.json", "--data", "data.csv", "--out", "out.csv"], &["out.csv"]),
    (
        &["compensate", "--fit", "fit.json", "--poses", "poses.csv", "--out", "out.csv", "--report", "page"],
        &["out.csv", "page"],
    ),
    (&["map", "--fit", "fit.json", "--points", "4", "--out", "out.csv"], &["out.csv"]),
    (&["plan", "--fit", "fit.json", "--count", "8", "--pool", "60", "--out", "out.csv"], &["out.csv"]),
    (&["export", "--fit", "fit.json", "--format", "dh", "--out", "out.csv"], &["out.csv"]),
    (&["export", "--fit", "fit.json", "--format", "iso230", "--out", "out.csv"], &["out.csv"]),
    (
        &[
            "compare",
            "--robot",
            "robot.toml",
            "--data",
            "data.csv",
            "--solver",
            "qr",
            "--solver",
            "lasso(cv)",
            "--json",
        ],
        &[],
    ),
];

/// All bytes of a file or folder, by name.
fn bytes(path: &Path, into: &mut BTreeMap<String, Vec<u8>>) {
    if path.is_dir() {
        std::fs::read_dir(path).unwrap().for_each(|entry| bytes(&entry.unwrap().path(), into));
    } else {
        into.insert(path.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(path).unwrap());
    }
}

/// What a run printed and wrote; wall times and the number of threads, which the page repeats, are left out.
fn result(folder: &Folder, arguments: &[&str], outputs: &[&str], threads: &str) -> BTreeMap<String, Vec<u8>> {
    let run = folder.run(&[arguments, &["--threads", threads]].concat()).ended(0);
    let told: String = run.out.lines().filter(|line| !line.trim_start().starts_with("\"seconds\"")).collect();
    let mut all = BTreeMap::from([("stdout".to_owned(), told.into_bytes())]);
    for output in outputs {
        bytes(&folder.file(output), &mut all);
    }
    for (name, content) in &mut all {
        if ["index.html", "run.json"].contains(&name.as_str()) {
            let text = String::from_utf8(content.clone()).unwrap();
            let page = text.replace(&format!("--threads {threads}"), "--threads N");
            *content =
                page.replace(&format!("\"--threads\",\n    \"{threads}\""), "\"--threads\", N").into_bytes();
        }
    }
    all
}

#[test]
fn every_verb_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::with_data();
    folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
    folder.run("predict --fit fit.json --data data.csv --out poses.csv").ended(0);
    for (arguments, outputs) in RUNS {
        let one = result(&folder, arguments, outputs, "1");
        assert!(one.len() > outputs.len() && one.values().any(|content| content.len() > 50), "{arguments:?}");
        for threads in if cfg!(feature = "slow") { &["2", "7"][..] } else { &["7"] } {
            let other = result(&folder, arguments, outputs, threads);
            assert_eq!(one.keys().collect::<Vec<_>>(), other.keys().collect::<Vec<_>>(), "{arguments:?}");
            for (name, content) in &one {
                assert!(
                    *content == other[name],
                    "{}: {name} differs on {threads} threads",
                    arguments.join(" ")
                );
            }
        }
    }
}
