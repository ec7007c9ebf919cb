//! The committed corpus.

use super::remarks;
use crate::folder::Folder;
use std::path::{Path, PathBuf};

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/spoiled")
}

/// A folder with the whole corpus, and a fit to predict and compensate with.
fn with_corpus() -> (Folder, Vec<String>) {
    let folder = Folder::empty();
    let mut names: Vec<String> = std::fs::read_dir(corpus())
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|entry| {
            std::fs::copy(entry.path(), folder.file(&entry.file_name().to_string_lossy())).unwrap();
            entry.file_name().to_string_lossy().into_owned()
        })
        .filter(|name| !["robot.toml", "good.csv", "make.py", "README.md"].contains(&name.as_str()))
        .collect();
    names.sort();
    let fitted =
        ["identify", "--robot", "robot.toml", "--data", "good.csv", "--folds", "0", "--out", "fit.json"];
    assert_eq!(remarks(&folder.run(&fitted)), "[0] ");
    (folder, names)
}

/// What is run on a file, by its name.
fn command(name: &str) -> Vec<&str> {
    let identify = ["identify", "--robot", "robot.toml", "--folds", "0", "--data"];
    match name.split('_').next() {
        Some("robot") => vec!["check", "--robot", name],
        Some("model") => [&identify[..], &["good.csv", "--model", name]].concat(),
        Some("poses") => vec!["compensate", "--fit", "fit.json", "--poses", name, "--out", "out.csv"],
        Some("fit") => vec!["predict", "--fit", name, "--data", "good.csv", "--out", "out.csv"],
        _ => [&identify[..], &[name, "--out", "out.json"]].concat(),
    }
}

#[test]
fn every_file_is_refused_or_remarked_upon() {
    let (folder, names) = with_corpus();
    let mut said = String::new();
    let mut count = 0;
    for name in names.iter().filter(|name| !name.starts_with("fine_")) {
        let before = folder.names();
        let run = folder.run(&command(name));
        let told = remarks(&run);
        match run.code {
            Some(2) => {
                assert!(
                    told.contains(&format!("error: {name}")) || told.contains("error: good.csv: effect"),
                    "{name}: {told}"
                );
                assert_eq!(run.out, "", "{name}: a result was printed");
                assert_eq!(folder.names(), before, "{name}: a file was left behind");
            }
            Some(0) => {
                let status = run.out.contains("unreachable") || run.out.contains("limit");
                assert!(told.contains("warning: ") || status, "{name}: nothing was said\n{}", run.out);
                for out in ["out.csv", "out.json"] {
                    let _ = std::fs::remove_file(folder.file(out));
                }
            }
            code => panic!("{name}: ended with {code:?}\n{told}"),
        }
        let told =
            if told == "[0] " { format!("[0] {}", run.out.lines().next().unwrap_or_default()) } else { told };
        said += &format!("{name}\n    {told}\n");
        count += 1;
    }
    assert!(count >= 60, "only {count} spoiled files");
    let mut settings = insta::Settings::clone_current();
    settings.add_filter(concat!(r"\btruepose ", env!("CARGO_PKG_VERSION"), r"\b"), "truepose [version]");
    settings.bind(|| insta::assert_snapshot!(said));
}

#[test]
fn another_dress_changes_no_result() {
    let (folder, names) = with_corpus();
    let result = |name: &str| {
        let run =
            folder.run(&["identify", "--robot", "robot.toml", "--data", name, "--folds", "0", "--json"]);
        assert_eq!(remarks(&run), "[0] ", "{name}");
        let mut json = serde_json::from_str::<serde_json::Value>(&run.out).unwrap();
        // Lines of the file are others where it has comments; parameters are differences of large numbers in mm.
        json["worst"]
            .as_array_mut()
            .unwrap()
            .iter_mut()
            .for_each(|error| error["line"].take().as_u64().map_or((), |_| ()));
        json["parameters"].take();
        json
    };
    let good = result("good.csv");
    let mut count = 0;
    for name in names.iter().filter(|name| name.starts_with("fine_")) {
        near(&good, &result(name), name);
        count += 1;
    }
    assert!(count >= 10, "only {count} files");
}

/// Equal but for rounding: numbers to 1e-6 of their size, and of what is next to nothing beside it.
fn near(a: &serde_json::Value, b: &serde_json::Value, at: &str) {
    use serde_json::Value;
    match (a, b) {
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{at}");
            a.iter().zip(b).enumerate().for_each(|(k, (a, b))| near(a, b, &format!("{at}/{k}")));
        }
        (Value::Object(a), Value::Object(b)) => {
            assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>(), "{at}");
            a.iter().for_each(|(key, a)| near(a, &b[key], &format!("{at}/{key}")));
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            // A gap above round-off is a share of round-off: its size is all that it says.
            if a.min(b) > 1e10 {
                assert!(a.max(b) < 10.0 * a.min(b), "{at}: {a} and {b}");
                return;
            }
            assert!((a - b).abs() <= 1e-6 * a.abs().max(b.abs()) + 1e-9, "{at}: {a} and {b}");
        }
        (a, b) => assert_eq!(a, b, "{at}"),
    }
}
