//! The lines of a robot program that are not as they were.

use super::Page;
use crate::count;
use crate::figure::escape;
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// Lines that are shown.
const SHOWN: usize = 200;

/// A line of a program before and after.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChangedLine {
    /// Name of its file.
    pub file: String,
    /// Its number, from 1.
    pub line: usize,
    /// Its text as it was read.
    pub before: String,
    /// And as it was written.
    pub after: String,
}

/// Pairs the lines of two texts of as many lines, and keeps those that differ.
pub fn changed_lines(file: &str, before: &[u8], after: &[u8]) -> Vec<ChangedLine> {
    let lines = |text: &'_ [u8]| -> Vec<String> {
        text.split(|&byte| byte == b'\n')
            .map(|line| String::from_utf8_lossy(line).trim_end().to_owned())
            .collect()
    };
    let pairs = lines(before).into_iter().zip(lines(after)).enumerate();
    let changed = pairs.filter(|(_, (before, after))| before != after);
    changed
        .map(|(k, (before, after))| ChangedLine { file: file.to_owned(), line: k + 1, before, after })
        .collect()
}

/// The changed lines, by file: as it was (−) and as it is (+).
pub(super) fn changed(page: &mut Page, lines: &[ChangedLine]) {
    if lines.is_empty() {
        return;
    }
    page.section("Changed lines");
    let shown = if lines.len() > SHOWN { format!("The first {SHOWN} of ") } else { String::new() };
    page.note(&format!(
        "{shown}{}: − as it was read, + as it was written.",
        count(lines.len(), "changed line")
    ));
    let width = lines.iter().take(SHOWN).map(|line| line.line).max().unwrap_or(0).to_string().len();
    let mut text = String::new();
    let mut file = "";
    for line in lines.iter().take(SHOWN) {
        if line.file != file {
            file = &line.file;
            let _ = writeln!(text, "<b>{}</b>", escape(file));
        }
        let _ = writeln!(text, "{:width$} <del>− {}</del>", line.line, escape(&line.before));
        let _ = writeln!(text, "{:width$} <ins>+ {}</ins>", "", escape(&line.after));
    }
    page.raw(&format!("<pre tabindex=\"0\" class=\"diff\">{text}</pre>"));
}
