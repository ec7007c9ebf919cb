//! Hostile input at every verb: more than 2000 runs, each of which ends in a result or in one clear message.
//!
//! [`contents`] spoils each kind of file in the same ways; [`surroundings`] spoils what is around the program: options, outputs, streams
//! and variables. Never a panic, a signal, a file that is half-written or left over.

mod contents;
mod good;
mod surroundings;

use crate::folder::Folder;
use good::good;
use std::process::{Command, Output};

/// Names of all files, in folders as well.
fn files(folder: &Folder) -> Vec<String> {
    let mut names = folder.names();
    if let Ok(page) = std::fs::read_dir(folder.file("page")) {
        names.extend(page.map(|entry| format!("page/{}", entry.unwrap().file_name().to_string_lossy())));
    }
    names.sort();
    names
}

/// What is wrong with how a run ended, if anything is.
fn unsound(output: &Output, outputs: &[&str], before: &[String], folder: &Folder) -> Option<String> {
    let log = String::from_utf8_lossy(&output.stderr);
    let after = files(folder);
    let new: Vec<&String> = after.iter().filter(|name| !before.contains(name)).collect();
    let gone = before.iter().find(|name| !after.contains(name));
    let errors =
        log.lines().filter(|line| line.starts_with("error: ") || line.starts_with("not met: ")).count();
    let steers = log.chars().any(|c| c.is_control() && !matches!(c, '\n' | '\t'));
    // `monitor` has found a change: no failure.
    let code = match output.status.code() {
        Some(3) if log.ends_with("the robot has changed\n") => Some(0),
        code => code,
    };
    let errors = if output.status.code() == Some(3) { 0 } else { errors };
    let problem = match code {
        None => "a signal",
        Some(0) if errors > 0 => "an error and success",
        Some(0) if new.iter().any(|name| !outputs.contains(&name.as_str())) => "an unknown file",
        Some(0) => return gone.map(|name| format!("{name} is gone")),
        Some(1 | 2) if log.contains("panicked") || log.contains("RUST_BACKTRACE") => "a panic",
        Some(1 | 2) if errors != 1 => "not one error",
        Some(1 | 2) if log.len() > 4000 => "a long message",
        Some(1 | 2) if steers => "a control character in the message",
        Some(1 | 2) if !new.is_empty() => "a file left over",
        Some(1 | 2) => return gone.map(|name| format!("{name} is gone")),
        Some(_) => "another exit code",
    };
    Some(format!(
        "{problem} ({:?}), files {new:?}: {}",
        output.status,
        log.chars().take(300).collect::<String>()
    ))
}

/// Runs the program; no run takes longer than twenty seconds.
fn program(folder: &Folder, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_truepose"));
    command.current_dir(folder.path()).args(words).args(["--time-limit", "20s", "--threads", "1"]);
    command
}

/// What was found in the cases of each part, and how many cases there were; every part in a folder of its own and at the same time.
fn each<T: Sync>(
    parts: &[T],
    run: impl Fn(&T, &Folder) -> (Vec<String>, usize) + Sync,
) -> (Vec<String>, usize) {
    let results = std::thread::scope(|scope| {
        let threads: Vec<_> = parts.iter().map(|part| scope.spawn(|| run(part, &good()))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect::<Vec<_>>()
    });
    let cases = results.iter().map(|(_, cases)| cases).sum();
    (results.into_iter().flat_map(|(found, _)| found).collect(), cases)
}

/// Fails with everything that was found.
#[track_caller]
fn none(found: Vec<String>, cases: usize, least: usize) {
    assert!(cases >= least, "{cases} cases");
    assert!(found.is_empty(), "{} of {cases} cases:\n{}", found.len(), found.join("\n"));
}
