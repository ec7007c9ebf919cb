//! A disk that runs full, signals, and names that are no text: all outputs of a run are there, or none.

use super::program;
use super::table::{files, table};
use crate::folder::Folder;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Whether every size and moment is tried, or some of them.
const SLOW: bool = cfg!(feature = "slow");

/// Runs in a folder on a file system of its own, of this size; none where none can be mounted.
fn on_a_disk_of(kilobytes: u32, folder: &Folder, line: &str) -> Option<(Option<i32>, Vec<String>, String)> {
    // A mount that is visible to this process alone, and gone with it.
    let script = format!(
        "mkdir -p disk && mount -t tmpfs -o size={kilobytes}k none disk || exit 77; \
         \"$0\" {line} >/dev/null; code=$?; find disk -mindepth 1 -printf '%P\\n'; exit $code"
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
    let folder = table().folder("fitted");
    for verb in [
        "identify --robot robot.toml --data data.csv --folds 0 --json --report disk/page --out disk/fit.json",
        "discover --robot robot.toml --data data.csv --most 0 --flips 99 --json --report disk/page --out disk/fit.json",
        "compensate --fit fit.json --poses data.csv --json --report disk/page --out disk/q.csv",
        "compare --robot robot.toml --data data.csv --solver qr --json --report disk/page",
    ] {
        let mut refused = 0;
        let sizes: &[u32] =
            if SLOW { &[4, 16, 32, 48, 64, 96, 128, 192, 256, 4096] } else { &[4, 48, 128, 4096] };
        for &kilobytes in sizes {
            let Some((code, listed, log)) = on_a_disk_of(kilobytes, &folder, verb) else {
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
        let of = sizes.len();
        assert!((1..of).contains(&refused), "{verb}: {refused} of {of} disks were too small");
    }
}

fn signal(child: &Child, name: &str) {
    Command::new("kill").args([name, &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
}

/// A signal in the last moments of a run.
#[test]
fn the_messages_of_an_interrupted_run_about_its_files_are_true() {
    let folder = Folder::with_data();
    let line = "discover --robot robot.toml --data data.csv --most 0 --flips 99 --report page --out fit.json";
    for step in 0..12 {
        let _ = std::fs::remove_dir_all(folder.file("page"));
        let _ = std::fs::remove_file(folder.file("fit.json"));
        let child = program(&folder, line).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        // As soon as the first file of the report is there, or a few milliseconds later.
        let result = folder.file("page/discovery.json");
        while !result.exists() {
            std::thread::sleep(Duration::from_micros(200));
        }
        std::thread::sleep(Duration::from_micros(300 * step));
        signal(&child, "-INT");
        let output = child.wait_with_output().unwrap();
        let log = String::from_utf8_lossy(&output.stderr);
        assert!(!log.contains("no file was written"), "{log}");
        for file in ["page/discovery.json", "page/run.json", "page/index.html", "fit.json"] {
            assert!(folder.file(file).exists(), "{file} is missing: {log}");
        }
    }
}

#[test]
fn being_killed_leaves_the_old_file_or_the_new_one() {
    let folder = table().folder("fitted");
    // Enough rows that writing takes a while.
    let data = folder.read("data.csv");
    let row = |line: &str| line.split(',').take(7).collect::<Vec<_>>().join(",") + "\n";
    let mut lines = data.lines().map(row);
    folder.write("many.csv", &(lines.next().unwrap() + &lines.next().unwrap().repeat(150_000)));
    let line = "predict --fit fit.json --data many.csv --out out.csv";
    let began = Instant::now();
    folder.run(&line.split(' ').collect::<Vec<_>>()).ended(0);
    let (whole, took) = (folder.read("out.csv"), began.elapsed());
    let (mut killed, steps) = (0, if SLOW { 16 } else { 6 });
    for step in 1..=steps {
        folder.write("out.csv", "an older result");
        let mut child = program(&folder, line).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(took * step / steps);
        child.kill().unwrap();
        killed += u32::from(!child.wait().unwrap().success());
        let (left, bytes) = (folder.read("out.csv"), whole.len());
        assert!(left == "an older result" || left == whole, "a file of {} bytes, not {bytes}", left.len());
    }
    assert!(killed > steps / 5, "the program was never killed: {killed}");
}

/// Processes that have the folder in their arguments or among their variables.
fn processes(folder: &Folder) -> Vec<String> {
    let name = folder.path().file_name().unwrap().to_string_lossy().into_owned();
    let all = std::fs::read_dir("/proc").unwrap().filter_map(Result::ok).map(|entry| entry.path());
    let of = |path: &std::path::PathBuf| {
        let read = |file: &str| std::fs::read(path.join(file)).unwrap_or_default();
        String::from_utf8_lossy(&[read("cmdline"), read("environ")].concat()).contains(&name)
    };
    all.filter(of).map(|path| path.display().to_string()).collect()
}

#[test]
fn verify_leaves_no_process_and_no_folder_when_it_is_ended() {
    let folder = table().folder("recorded");
    let record = folder.read("page/run.json").replace("\"99\"", "\"99\",\"--nested\",\"50\"");
    folder.write("page/run.json", &record);
    let temporary = || files(&folder, false).into_keys().filter(|name| name.starts_with("tmp/")).count();
    for (end, code) in [("--time-limit=1s", 3), ("-INT", 130), ("-TERM", 130)] {
        let mut command = program(&folder, "verify page/run.json");
        command.env("TMPDIR", folder.file("tmp")).args(Some(end).filter(|end| end.starts_with("--")));
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        if code == 130 {
            std::thread::sleep(Duration::from_millis(1000));
            assert!(temporary() > 0, "the run was not repeated yet, or is over");
            signal(&child, end);
        }
        assert_eq!(child.wait().unwrap().code(), Some(code), "{end}");
        assert_eq!(temporary(), 0, "{end}");
        assert_eq!(processes(&folder), [""; 0], "{end}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_text_are_names() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::with_data();
    let [data, fit, page, record] =
        [&b"m\xe4.csv"[..], b"f\xe4.json", b"r\xe4", b"r\xe4/run.json"].map(OsStr::from_bytes);
    std::fs::rename(folder.file("data.csv"), folder.path().join(data)).unwrap();
    let run = |line: &str, names: &[(&str, &OsStr)], code: i32, words: &str| {
        let mut command = program(&folder, line);
        for (option, name) in names {
            command.args((!option.is_empty()).then_some(option)).arg(name);
        }
        let output = command.output().unwrap();
        let log = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{log}");
        assert!(log.contains(words), "{log}");
    };
    let names = [("--data", data), ("--out", fit), ("--report", page)];
    let words = "is not UTF-8: `truepose verify` cannot repeat this run";
    run("identify --robot robot.toml", &names, 0, words);
    run("predict --out p.csv --json", &[("--fit", fit), ("--data", data)], 0, "");
    run("verify", &[("", record)], 2, "error: m\u{fffd}.csv: cannot be read");
}
