//! Spoiled input: every way in which people's files were ever wrong, and exactly what is said about it.
//!
//! [`files`] runs the corpus in `tests/spoiled`; [`tables`] makes mistakes in a good campaign that only the whole of it shows;
//! [`system`] has what is too large or too strange to be committed; [`runs`] asks for what cannot be meant.

mod files;
mod runs;
mod system;
mod tables;

use crate::folder::Run;

/// What a run said that was not asked for: its exit code, its errors and its warnings.
pub fn remarks(run: &Run) -> String {
    let warnings = run.out.lines().filter(|line| line.starts_with("warning: "));
    let all: Vec<&str> = run.log.lines().filter(|line| !line.starts_with("wrote ")).chain(warnings).collect();
    format!("[{}] {}", run.code.unwrap_or(-1), all.join("\n    "))
}
