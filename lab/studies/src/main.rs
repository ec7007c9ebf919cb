#![doc = include_str!("../README.md")]

mod clock;
mod closed_loop;
mod discovery;
mod draw;
mod guard_band;
mod harm;
mod journal;
mod kinds;
mod orders;
mod parts;
mod pps;
mod prelude;
mod reliability;
mod results;
mod sensitivity;
mod sessions;
mod simulated;
mod solvers;
mod stats;
mod table;
mod unseen;
mod words;

use prelude::Outcome;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

type Run = fn(&[String]) -> Outcome;

const STUDIES: [(&str, Run); 11] = [
    ("closed-loop", closed_loop::run),
    ("discovery", discovery::run),
    ("guard-band", guard_band::run),
    ("harm", harm::run),
    ("kinds", kinds::run),
    ("orders", orders::run),
    ("pps", pps::run),
    ("reliability", reliability::run),
    ("sensitivity", sensitivity::run),
    ("sessions", sessions::run),
    ("solvers", solvers::run),
];

/// Folder for the records and tables of a study.
pub fn folder(study: &str) -> std::io::Result<PathBuf> {
    let root = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from);
    let folder = root.join("studies").join(study);
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// The options of a study.
pub fn parsed<A: clap::Parser>(arguments: &[String]) -> Outcome<A> {
    Ok(A::try_parse_from(std::iter::once("study").chain(arguments.iter().map(String::as_str)))?)
}

/// Text to the terminal.
pub fn print(text: &str) {
    let _ = writeln!(std::io::stdout().lock(), "{text}");
}

fn main() -> ExitCode {
    let name = std::env::args().nth(1).unwrap_or_default();
    let rest: Vec<String> = std::env::args().skip(2).collect();
    let half = rest.iter().any(|word| word == "--half");
    let done = match STUDIES.iter().find(|(known, _)| name == *known) {
        Some(_) if name == "reliability" && half => unseen::run(&rest),
        Some((_, run)) => run(&rest),
        None => {
            Err(format!("unknown study `{name}`; there are: {}", STUDIES.map(|(known, _)| known).join(", "))
                .into())
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(std::io::stderr().lock(), "error: {error}");
            ExitCode::from(2)
        }
    }
}
