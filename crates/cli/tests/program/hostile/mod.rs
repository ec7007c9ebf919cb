//! Hostile input: whatever is wrong with a file, an option, an output or what is around the program ends in a result or in one clear
//! message with its place, and leaves nothing behind.
//!
//! Cases are lines of `*.toml`: what is done to a good folder, the command line, the expected exit code, messages and files ([`table`]).
//! [`contents`] spoils each kind of file in each way of that table; [`processes`] has what needs code: full disks, signals, names
//! that are no text; [`outputs`] reads what is written.

mod changes;
mod contents;
mod near;
mod outputs;
mod processes;
mod sheet;
mod table;

use crate::folder::{Folder, Run};
use std::process::Command;
use table::{Files, table};

#[test]
fn hostile_input_is_refused_with_its_place() {
    // `CASE=words` runs the cases with these words in their names or commands alone.
    let only = std::env::var("CASE").unwrap_or_default();
    let (found, cases) = table::failures(table(), &only);
    none(
        found,
        cases,
        if !only.is_empty() {
            1
        } else if cfg!(feature = "slow") {
            770
        } else {
            560
        },
    );
}

#[test]
fn every_file_of_the_corpus_has_a_case() {
    let cases = table().group.iter().flat_map(table::Group::cases).map(|(_, case)| case.unwrap().name);
    let cases: std::collections::BTreeSet<String> = cases.collect();
    let names = std::fs::read_dir(changes::corpus()).unwrap();
    let names = names.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    let others = ["robot.toml", "good.csv", "make.py", "README.md"];
    let missing: Vec<String> =
        names.filter(|name| !cases.contains(name) && !others.contains(&name.as_str())).collect();
    assert_eq!(missing, [""; 0]);
}

/// The program, to be run in a folder.
fn program(folder: &Folder, words: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_truepose"));
    command.current_dir(folder.path()).args(words.split(' '));
    command
}

/// What is wrong with how a run ended, if anything is: never a panic, a signal, a file that is half-written or left over.
fn unsound(run: &Run, outputs: &[&str], before: &Files, after: &Files) -> Option<String> {
    let log = &run.log;
    let new: Vec<&String> = after.keys().filter(|name| !before.contains_key(*name)).collect();
    let gone = before.keys().find(|name| !after.contains_key(*name));
    let output = |name: &str| outputs.contains(&name.split('/').next().unwrap_or(name));
    let errors =
        log.lines().filter(|line| line.starts_with("error: ") || line.starts_with("not met: ")).count();
    let steers = log.chars().any(|c| c.is_control() && !matches!(c, '\n' | '\t'));
    // `monitor` has found a change: no failure.
    let (code, errors) = match run.code {
        Some(3) if log.ends_with("the robot has changed\n") => (Some(0), 0),
        Some(3) => (Some(3), 0),
        code => (code, errors),
    };
    let problem = match code {
        None => "a signal",
        Some(0) if errors > 0 => "an error and success",
        Some(0) if new.iter().any(|name| !output(name)) => "an unknown file",
        Some(0) => return gone.map(|name| format!("{name} is gone")),
        Some(1 | 2) if log.contains("panicked") || log.contains("RUST_BACKTRACE") => "a panic",
        Some(1 | 2) if errors != 1 => "not one error",
        Some(1 | 2) if log.len() > 4000 => "a long message",
        Some(1 | 2) if steers => "a control character in the message",
        Some(1 | 2) if !new.is_empty() => "a file left over",
        Some(1 | 2) => return gone.map(|name| format!("{name} is gone")),
        Some(_) => "another exit code",
    };
    Some(format!("{problem} ({:?}), files {new:?}: {}", run.code, log.chars().take(300).collect::<String>()))
}

/// Fails with everything that was found.
#[track_caller]
fn none(found: Vec<String>, cases: usize, least: usize) {
    assert!(cases >= least, "{cases} cases");
    assert!(found.is_empty(), "{} of {cases} cases:\n{}", found.len(), found.join("\n"));
    println!("{cases} cases");
}
