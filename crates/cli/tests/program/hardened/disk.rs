//! A disk that runs full, or a signal between two files: all outputs of a run are there, or none.

use crate::folder::Folder;
use std::process::{Command, Stdio};

/// Runs in a folder on a file system of its own, of this size; none where none can be mounted.
fn on_a_disk_of(kilobytes: u32, folder: &Folder, words: &str) -> Option<(Option<i32>, Vec<String>, String)> {
    // A mount that nobody else sees, gone with the process.
    let script = format!(
        "mkdir -p disk && mount -t tmpfs -o size={kilobytes}k none disk || exit 77; \
         \"$0\" {words}; code=$?; find disk -mindepth 1 -printf '%P\\n'; exit $code"
    );
    let output = Command::new("unshare")
        .args(["--mount", "--map-root-user", "sh", "-c", &script, env!("CARGO_BIN_EXE_truepose")])
        .current_dir(folder.path())
        .output()
        .ok()?;
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    let refused = output.status.code() == Some(77) || log.starts_with("unshare:");
    let files = String::from_utf8_lossy(&output.stdout).lines().map(String::from).collect();
    (!refused).then_some((output.status.code(), files, log))
}

#[test]
fn a_full_disk_leaves_no_part_of_a_report() {
    let folder = Folder::with_data();
    let run = |words: &str| folder.run(&words.split(' ').collect::<Vec<_>>()).ended(0);
    run("identify --robot robot.toml --data data.csv --folds 0 --out fit.json");
    for verb in [
        "identify --robot robot.toml --data data.csv --folds 0 --json --report disk/page --out disk/fit.json",
        "discover --robot robot.toml --data data.csv --most 0 --flips 99 --json --report disk/page --out disk/fit.json",
        "compensate --fit fit.json --poses data.csv --json --report disk/page --out disk/q.csv",
        "compare --robot robot.toml --data data.csv --solver qr --json --report disk/page",
    ] {
        let mut refused = 0;
        for kilobytes in [4, 16, 32, 48, 64, 96, 128, 192, 256, 4096] {
            let Some((code, listed, log)) = on_a_disk_of(kilobytes, &folder, &format!("{verb} >/dev/null"))
            else {
                println!("SKIPPED: no file system can be mounted here");
                return;
            };
            let left: Vec<&String> = listed.iter().filter(|name| *name != "page").collect();
            if code == Some(0) {
                assert!(left.iter().any(|name| *name == "page/index.html"), "{verb}: {left:?}");
            } else {
                assert_eq!((code, left.len()), (Some(2), 0), "{verb} on {kilobytes} kB: {left:?} {log}");
                assert!(log.contains("no space left on device"), "{log}");
                refused += 1;
            }
        }
        assert!((1..10).contains(&refused), "{verb}: {refused} of 10 disks were too small");
    }
}

/// A signal in the last moments of a run: what is said of the files is true.
#[test]
fn what_an_interrupted_run_says_of_its_files_is_true() {
    let folder = Folder::with_data();
    let words: Vec<&str> =
        "discover --robot robot.toml --data data.csv --most 0 --flips 99 --report page --out fit.json"
            .split(' ')
            .collect();
    for step in 0..12 {
        let _ = std::fs::remove_dir_all(folder.file("page"));
        let _ = std::fs::remove_file(folder.file("fit.json"));
        let child = Command::new(env!("CARGO_BIN_EXE_truepose"))
            .current_dir(folder.path())
            .args(&words)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // As soon as the first file of the report is there, or a few milliseconds later.
        let result = folder.file("page/discovery.json");
        while !result.exists() {
            std::thread::sleep(std::time::Duration::from_micros(200));
        }
        std::thread::sleep(std::time::Duration::from_micros(300 * step));
        Command::new("kill").args(["-INT", &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
        let output = child.wait_with_output().unwrap();
        let log = String::from_utf8_lossy(&output.stderr);
        assert!(!log.contains("no file was written"), "{log}");
        for file in ["page/discovery.json", "page/run.json", "page/index.html", "fit.json"] {
            assert!(folder.file(file).exists(), "{file} is missing: {log}");
        }
    }
}

#[test]
fn a_run_that_fails_leaves_no_empty_folder() {
    let folder = Folder::with_data();
    std::fs::create_dir(folder.file("mine")).unwrap();
    let before = folder.names();
    for report in ["page", "above/page", "mine"] {
        let words =
            format!("identify --robot robot.toml --data data.csv --certificate data.csv --report {report}");
        folder.run(&words.split(' ').collect::<Vec<_>>()).ended(2);
        let words = format!("discover --robot data.csv --data data.csv --rivals {report} --out fit.json");
        folder.run(&words.split(' ').collect::<Vec<_>>()).ended(2);
        // One that was there stays.
        assert_eq!(folder.names(), before, "{report}");
    }
}
