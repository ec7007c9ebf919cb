//! A run that is interrupted, or reaches a limit, ends at once, says what it had found, and leaves no half-written file.

use crate::folder::Folder;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const DISCOVER: &[&str] = &[
    "discover",
    "--robot",
    "robot.toml",
    "--data",
    "data.csv",
    "--out",
    "fit.json",
    "--report",
    "page",
    "--rotations",
    "99999",
];

/// Enough work for minutes.
fn busy() -> Folder {
    let folder = crate::report::measured("small", "j1");
    let plant = folder.read("plant.toml").replace("visits = 60", "visits = 400");
    folder.write("plant.toml", &plant);
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    folder.write("fit.json", "an older result");
    folder
}

#[test]
fn an_interrupted_run_ends_within_a_second_and_reports_its_findings() {
    for (signal, more) in [("-INT", &[][..]), ("-TERM", &["--json"])] {
        let folder = busy();
        let child = Command::new(env!("CARGO_BIN_EXE_truepose"))
            .current_dir(folder.path())
            .args(DISCOVER)
            .args(more)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(1500));
        let asked = Instant::now();
        Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        let output = child.wait_with_output().unwrap();
        assert!(asked.elapsed() < Duration::from_secs(1), "{:?}", asked.elapsed());
        assert_eq!(output.status.code(), Some(130));
        let out = String::from_utf8(output.stdout).unwrap();
        if more.is_empty() {
            assert!(
                out.starts_with("INCOMPLETE: interrupted after ") && out.contains("Findings so far: "),
                "{out}"
            );
        } else {
            let value: serde_json::Value = serde_json::from_str(&out).unwrap();
            assert_eq!(value["incomplete"], true, "{out}");
        }
        untouched(&folder);
    }
}

#[test]
fn limits_that_the_caller_sets_are_kept() {
    for (limit, words) in [
        ("--time-limit=1s", "the time limit was reached"),
        ("--memory-limit=1MB", "the memory limit was reached"),
    ] {
        let folder = busy();
        let began = Instant::now();
        let run = folder.run(&[DISCOVER, &[limit]].concat()).ended(3);
        assert!(began.elapsed() < Duration::from_secs(3), "{limit}: {:?}", began.elapsed());
        assert!(run.out.starts_with("INCOMPLETE: ") && run.log.contains(words), "{}{}", run.out, run.log);
        untouched(&folder);
    }
    let folder = Folder::with_data();
    folder.run("check --robot robot.toml --time-limit 1min --memory-limit 4GB").ended(0);
    folder.run("check --robot robot.toml --time-limit 3").ended(2);
}

/// With few flips the first find comes soon, and whole runs in each of eight folds come after it.
#[cfg(feature = "slow")]
#[test]
fn findings_before_a_limit_are_kept_and_marked_as_incomplete() {
    let folder = busy();
    let run = |limit: &str| {
        let mut words: Vec<&str> = DISCOVER[..DISCOVER.len() - 2].to_vec();
        words.extend(["--nested", "8", "--time-limit", limit]);
        folder.run(&words)
    };
    // Machines differ: the first limit after which a finding was in the model (between its announcement and its fit nothing is kept).
    let limits = ["1s", "2s", "4s", "8s", "16s", "32s", "64s"];
    let run =
        limits.into_iter().map(run).find(|run| !run.log.contains("no file was written")).unwrap().ended(3);
    assert!(!run.out.contains("Findings so far: none"), "{}", run.out);
    assert!(run.out.starts_with("INCOMPLETE: "), "{}", run.out);
    assert!(run.log.contains("fit.json and page/discovery.json, marked as incomplete"), "{}", run.log);
    let json = |name: &str| -> serde_json::Value { folder.json(name) };
    let (fit, result) = (json("fit.json"), json("page/discovery.json"));
    assert!(result["incomplete"].as_str().unwrap().starts_with("the time limit was reached"), "{result}");
    // On a machine that came to the end of the search the finished run is shown as well, without its validation.
    let finished = result["stopped"] != "interrupted";
    assert_eq!(run.out.contains(" mm on the held-out test set"), finished, "{}", run.out);
    assert!(!result["effects"].as_array().unwrap().is_empty(), "{result}");
    assert!(result["after"]["holdout"]["rms_mm"].as_f64() < result["before"]["holdout"]["rms_mm"].as_f64());
    assert_eq!(fit["provenance"]["incomplete"] == "the time limit was reached", !finished, "{fit}");
    assert!(folder.names().iter().all(|name| !name.starts_with(".truepose")), "{:?}", folder.names());
    // It is a fit like any other.
    folder.run("predict --fit fit.json --data data.csv --out p.csv").ended(0);
}

fn untouched(folder: &Folder) {
    assert_eq!(folder.read("fit.json"), "an older result");
    assert!(folder.names().iter().all(|name| !name.starts_with(".truepose")), "{:?}", folder.names());
    let page: Vec<_> =
        std::fs::read_dir(folder.file("page")).map(|entries| entries.collect()).unwrap_or_default();
    assert!(page.is_empty(), "{page:?}");
}
