//! `verify` reads a file that anyone may have written: it writes nothing, and leaves nothing, outside of a folder of its own.

use crate::folder::Folder;
use std::process::{Command, Stdio};
use std::time::Duration;

/// A folder with a recorded run of `discover`; its temporary files are in `tmp`.
fn recorded() -> Folder {
    let folder = Folder::with_data();
    let run = "discover --robot robot.toml --data data.csv --report page --most 0 --flips 99";
    folder.run(&run.split(' ').collect::<Vec<_>>()).ended(0);
    std::fs::create_dir(folder.file("tmp")).unwrap();
    folder
}

/// Changes the arguments of the record.
fn craft(folder: &Folder, change: impl FnOnce(&mut Vec<serde_json::Value>)) {
    let mut run: serde_json::Value = serde_json::from_str(&folder.read("page/run.json")).unwrap();
    change(run["arguments"].as_array_mut().unwrap());
    folder.write("page/run.json", &run.to_string());
}

fn verify(folder: &Folder, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_truepose"));
    command.current_dir(folder.path()).env("TMPDIR", folder.file("tmp")).arg("verify").args(more);
    command.arg("page/run.json");
    command
}

fn temporary(folder: &Folder) -> Vec<String> {
    let entries = std::fs::read_dir(folder.file("tmp")).unwrap();
    entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

/// Processes that have the folder in their arguments or among their variables.
fn processes(folder: &Folder) -> Vec<String> {
    let name = folder.path().file_name().unwrap().to_string_lossy().into_owned();
    let all = std::fs::read_dir("/proc").unwrap().filter_map(Result::ok).map(|entry| entry.path());
    let of = |path: &std::path::PathBuf| {
        let read = |file: &str| std::fs::read(path.join(file)).unwrap_or_default();
        let words = [read("cmdline"), read("environ")].concat();
        String::from_utf8_lossy(&words).contains(&name)
    };
    all.filter(of).map(|path| path.display().to_string()).collect()
}

#[test]
fn verify_writes_no_file_that_its_record_names() {
    let folder = recorded();
    let before = folder.names();
    for outputs in [
        &["--rivals", "planted"][..],
        &["--rivals=planted"],
        &["--rivals", "planted", "--out", "planted.json"],
        &["--out=planted.json"],
        &["--report", "planted"],
    ] {
        let folder = &folder;
        let kept = folder.read("page/run.json");
        craft(folder, |arguments| {
            let own = outputs.iter().map(|word| word.split('=').next().unwrap());
            for option in own {
                if let Some(at) = arguments.iter().position(|word| word == option) {
                    arguments.drain(at..at + 2);
                }
            }
            arguments.extend(outputs.iter().map(|&word| word.into()));
        });
        let output = verify(folder, &[]).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(folder.names(), before, "{outputs:?}");
        assert_eq!(temporary(folder), [""; 0]);
        folder.write("page/run.json", &kept);
    }
}

#[test]
fn verify_refuses_arguments_and_inputs_that_are_not_of_a_run() {
    let folder = recorded();
    let kept = folder.read("page/run.json");
    let refused = |change: &dyn Fn(&mut Vec<serde_json::Value>), words: &str| {
        craft(&folder, |arguments| change(arguments));
        let output = verify(&folder, &[]).output().unwrap();
        let log = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{log}");
        assert!(log.starts_with("error: page/run.json: ") && log.contains(words), "{log}");
        assert_eq!(log.lines().count(), 1, "{log}");
        assert_eq!(temporary(&folder), [""; 0]);
        folder.write("page/run.json", &kept);
    };
    refused(&|a| a.push("--write=x".into()), "unexpected argument '--write'");
    refused(&|a| a.push("x".into()), "unexpected argument 'x'");
    refused(&|a| a.clear(), "its arguments are not valid");
    refused(&|a| *a = vec!["--help".into()], "its arguments are not valid");
    refused(
        &|a| *a = ["simulate", "--plant", "plant.toml", "--out", "planted.csv"].map(Into::into).to_vec(),
        "only discover, identify, compare, compensate, iso9283, map, plan and predict can be repeated",
    );
    // A word of another option is no verb.
    refused(
        &|a| {
            *a = ["predict", "--fit", "identify", "--data", "d", "--out", "planted"].map(Into::into).to_vec()
        },
        "the result of this run is `prediction.json`",
    );
    refused(&|a| a.extend(["--model", "other.toml"].map(Into::into)), "is not among the inputs");
    std::fs::remove_file(folder.file("data.csv")).unwrap();
    Command::new("mkfifo").arg(folder.file("data.csv")).status().unwrap();
    refused(&|_| (), "is not a regular file, and cannot be read again");
}

#[test]
fn verify_leaves_no_process_and_no_folder_when_it_is_ended() {
    let folder = recorded();
    craft(&folder, |arguments| arguments.extend(["--nested", "50"].map(Into::into)));
    for end in ["--time-limit=1s", "-INT", "-TERM"] {
        let more = if end.starts_with("--") { &[end][..] } else { &[] };
        let mut child = verify(&folder, more).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        if more.is_empty() {
            std::thread::sleep(Duration::from_millis(1000));
            assert!(!temporary(&folder).is_empty(), "the run was not repeated yet, or is over");
            Command::new("kill").args([end, &child.id().to_string()]).status().unwrap();
        }
        let code = child.wait().unwrap().code();
        assert_eq!(code, Some(if more.is_empty() { 130 } else { 3 }), "{end}");
        assert_eq!(temporary(&folder), [""; 0], "{end}");
        assert_eq!(processes(&folder), [""; 0], "{end}");
    }
}
