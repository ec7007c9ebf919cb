//! A pipe can be read once: every verb that takes a table takes one through a pipe, or refuses it at once.

use crate::folder::Folder;
use std::io::Write;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Ends with this code within ten seconds, given the text on standard input; what it printed.
fn piped(folder: &Folder, words: &str, text: &str, code: i32) -> String {
    let mut child = Command::new(env!("CARGO_BIN_EXE_truepose"))
        .current_dir(folder.path())
        .args(words.split(' '))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let text = text.to_owned();
    // It may end without reading.
    let writer = std::thread::spawn(move || drop(input.write_all(text.as_bytes())));
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > Duration::from_secs(10) {
            child.kill().unwrap();
            panic!("{words}: no end");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{words}: {log}");
    String::from_utf8_lossy(&output.stdout).into_owned() + &log
}

fn fitted() -> Folder {
    let folder = Folder::with_data();
    let fit = "identify --robot robot.toml --data data.csv --folds 0 --out fit.json";
    folder.run(&fit.split(' ').collect::<Vec<_>>()).ended(0);
    folder
}

#[test]
fn a_dash_is_standard_input_for_every_table_fit_and_model() {
    let folder = fitted();
    let (data, fit) = (folder.read("data.csv"), folder.read("fit.json"));
    folder.write("model.toml", "[[effects]]\nfamily = \"geometric\"\n");
    for (words, file) in [
        ("predict --fit fit.json --data - --out from.csv", "data.csv"),
        ("predict --fit - --data data.csv --out from.csv", "fit.json"),
        ("compensate --fit fit.json --poses - --out from.csv", "data.csv"),
        ("plan --fit fit.json --at - --count 2 --out from.csv", "data.csv"),
        ("simulate --plant - --out from.csv", "plant.toml"),
    ] {
        piped(&folder, words, &folder.read(file), 0);
        let through = folder.read("from.csv");
        folder.run(&words.replace(" - ", &format!(" {file} ")).split(' ').collect::<Vec<_>>()).ended(0);
        assert_eq!(folder.read("from.csv"), through, "{words}");
    }
    let identify = "identify --robot robot.toml --folds 0 --data - --json";
    let from_file =
        folder.run(&identify.replace("- ", "data.csv ").split(' ').collect::<Vec<_>>()).ended(0).out;
    assert_eq!(piped(&folder, identify, &data, 0), from_file);
    piped(
        &folder,
        "identify --robot robot.toml --folds 0 --data data.csv --model -",
        &folder.read("model.toml"),
        0,
    );
    piped(&folder, "check --robot robot.toml --data -", &data, 0);
    let twice = piped(&folder, "predict --fit - --data - --out from.csv", &fit, 2);
    assert_eq!(twice, "error: --data: `/dev/stdin` is read by --fit already, and can be read only once\n");
    let streamed = piped(&folder, "identify --robot robot.toml --stream --data -", &data, 2);
    assert!(streamed.starts_with("error: --stream: reads the data several times"), "{streamed}");
}

#[test]
fn a_named_pipe_is_read_once() {
    let folder = fitted();
    Command::new("mkfifo").arg(folder.file("pipe")).status().unwrap();
    for words in [
        "predict --fit fit.json --data pipe --out out.csv",
        "compensate --fit fit.json --poses pipe --out out.csv",
        "identify --robot robot.toml --data pipe --folds 0 --out out.json",
        "check --robot robot.toml --data pipe",
    ] {
        let (from, to) = (folder.file("data.csv"), folder.file("pipe"));
        let writer = std::thread::spawn(move || {
            let data = std::fs::read(from).unwrap();
            // A reader that has gone is not this thread's concern.
            let _ =
                std::fs::OpenOptions::new().write(true).open(to).and_then(|mut pipe| pipe.write_all(&data));
        });
        piped(&folder, words, "", 0);
        writer.join().unwrap();
    }
}
