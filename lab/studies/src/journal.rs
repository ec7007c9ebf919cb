//! The journal of a study: each record is written as soon as it is done, so that an interrupted run can be continued.

use std::error::Error;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What one line holds.
pub trait Line: Sized {
    /// The columns.
    const HEADER: &'static str;

    /// As a row; numbers come back to the bit.
    fn row(&self) -> String;

    /// From a row; none when it was cut off.
    fn of(row: &str) -> Option<Self>;
}

/// The lines of one part of a study.
pub struct Journal<L> {
    path: PathBuf,
    pub records: Vec<L>,
}

impl<L: Line> Journal<L> {
    /// Takes up what is there; a line that was cut off is dropped.
    pub fn open(folder: &Path, part: &str, commit: &str) -> Result<Self, Box<dyn Error>> {
        let path = folder.join(format!("{part}.csv"));
        let text = fs::read_to_string(&path).unwrap_or_default();
        let records: Vec<L> = text.lines().filter_map(L::of).collect();
        let rows: String = records.iter().map(|record| record.row() + "\n").collect();
        if !text.ends_with('\n') {
            fs::write(&path, format!("# commit {commit}\n{}\n{rows}", L::HEADER))?;
        }
        Ok(Journal { path, records })
    }

    /// Writes one line.
    pub fn add(&mut self, record: L) -> Result<(), Box<dyn Error>> {
        let mut file = fs::OpenOptions::new().append(true).open(&self.path)?;
        file.write_all((record.row() + "\n").as_bytes())?;
        self.records.push(record);
        Ok(())
    }
}

/// The commit that is checked out, with a mark when files differ from it; `unknown` outside of a repository.
pub fn commit() -> String {
    let git = |arguments: &[&str]| {
        let done = Command::new("git").args(arguments).output().ok().filter(|done| done.status.success())?;
        Some(String::from_utf8_lossy(&done.stdout).trim().to_owned())
    };
    let Some(head) = git(&["rev-parse", "HEAD"]) else { return "unknown".into() };
    let changed =
        git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|list| !list.is_empty());
    if changed { format!("{head}-changed") } else { head }
}
