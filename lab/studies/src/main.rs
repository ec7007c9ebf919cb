#![doc = include_str!("../README.md")]

mod clock;
mod closed_loop;
mod discovery;
mod document;
mod guard_band;
mod harm;
mod journal;
mod kinds;
mod orders;
mod parts;
mod pps;
mod reliability;
mod sensitivity;
mod sessions;
mod solvers;
mod unseen;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Folder for the tables and figures of a study.
fn folder(study: &str) -> std::io::Result<PathBuf> {
    let root = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from);
    let folder = root.join("studies").join(study);
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// Text to the terminal.
fn print(text: &str) {
    let _ = writeln!(std::io::stdout().lock(), "{text}");
}

fn main() -> ExitCode {
    let name = std::env::args().nth(1).unwrap_or_default();
    let rest: Vec<String> = std::env::args().skip(2).collect();
    let done = match name.as_str() {
        "discovery" => discovery::run(&rest),
        "closed-loop" | "drive" => closed_loop::run(&rest),
        "guard-band" => guard_band::run(&rest),
        "harm" => harm::run(&rest),
        "kinds" => kinds::run(&rest),
        "orders" => orders::run(),
        "pps" => pps::run(&rest),
        "reliability" if rest.iter().any(|word| word == "--half") => unseen::run(&rest),
        "reliability" => reliability::run(&rest),
        "sensitivity" => sensitivity::run(&rest),
        "sessions" => sessions::run(&rest),
        "solvers" => solvers::run(),
        _ => Err(format!(
            "unknown study `{name}`; there are: closed-loop, discovery, guard-band, harm, kinds, orders, pps, reliability, sensitivity, sessions, solvers"
        )
        .into()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(std::io::stderr().lock(), "error: {error}");
            ExitCode::from(2)
        }
    }
}
