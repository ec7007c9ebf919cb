//! What a run leaves: its tables in `lab/results/STUDY.md`, and the parts of `lab/results/reliability.md`.
//!
//! A run has a section of its own, with its command, its commit and its date; it replaces the section of the same command.

use crate::journal::commit;
use crate::prelude::*;
use std::fs;
use std::time::{SystemTime, UNIX_EPOCH};

/// Ends a run: the text is printed, written to a file beside its records, and becomes its section of the results.
pub fn finish(study: &str, file: &Path, text: &str) -> Outcome {
    print(text);
    keep(study, file, text)
}

/// The same of a text that was printed as it was made.
pub fn keep(study: &str, file: &Path, text: &str) -> Outcome {
    fs::write(file, text)?;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../results/{study}.md"));
    let page = fs::read_to_string(&path).unwrap_or_else(|_| {
        format!("# Results of `{study}`\n\nA run of the study writes its section, which replaces the one of the same command; nothing here is typed.\n")
    });
    let words: Vec<String> = std::env::args().skip(1).map(quoted).collect();
    let command = format!("cargo xtask study {}", words.join(" "));
    let days = SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs() / 86_400;
    // Tables in Markdown stay; columns of text keep their places.
    let tables = text.trim();
    let body = if tables.contains("| --- |") { tables.to_owned() } else { format!("```text\n{tables}\n```") };
    let section = format!("Commit {}, {}.\n\n{body}\n", commit(), date(days));
    fs::write(&path, replaced(&page, &command, &section))?;
    print(&format!("records in {}; tables in lab/results/{study}.md", file.display()));
    Ok(())
}

/// Writes the part of this name of `lab/results/reliability.md`, between its two markers; other text is not changed.
pub fn publish(part: &str, tables: &str) -> Outcome {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../results/reliability.md");
    let text = fs::read_to_string(&path)?;
    let published = published(&text, part, tables)
        .ok_or_else(|| format!("{}: the markers of `{part}` are missing", path.display()))?;
    Ok(fs::write(&path, published)?)
}

fn published(text: &str, part: &str, tables: &str) -> Option<String> {
    let (begin, end) = (format!("<!-- study {part}: begin -->"), format!("<!-- study {part}: end -->"));
    let (before, rest) = text.split_once(&begin)?;
    let (_, after) = rest.split_once(&end)?;
    Some(format!("{before}{begin}\n\n{}\n\n{end}{after}", tables.trim()))
}

/// A word as it is typed.
fn quoted(word: String) -> String {
    if word.contains(' ') { format!("'{word}'") } else { word }
}

/// The page with the section of this command in place of the one that it had, or at its end.
fn replaced(page: &str, command: &str, section: &str) -> String {
    let head = format!("## `{command}`\n");
    let section = format!("{head}\n{section}");
    let Some(at) = page.find(&head) else { return format!("{}\n\n{section}", page.trim_end()) };
    let rest = &page[at + head.len()..];
    let after = rest.find("\n## `cargo xtask study").map_or("", |end| &rest[end..]);
    format!("{}{section}{after}", &page[..at])
}

/// The day of this many days since 1970-01-01, in the Gregorian calendar.
fn date(days: u64) -> String {
    let leap = |year: u64| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let (mut year, mut left) = (1970, days);
    while left >= 365 + u64::from(leap(year)) {
        left -= 365 + u64::from(leap(year));
        year += 1;
    }
    let lengths = [31, 28 + u64::from(leap(year)), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let mut month = 0;
    while left >= lengths[month] {
        left -= lengths[month];
        month += 1;
    }
    format!("{year}-{:02}-{:02}", month + 1, left + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_replaces_the_one_of_its_command() {
        let page = "# a\n\n## `cargo xtask study a`\n\nold\n\n## `cargo xtask study a --short`\n\nshort\n";
        let new = replaced(page, "cargo xtask study a", "new\n");
        assert_eq!(new, page.replace("old", "new"));
        let more = replaced(&new, "cargo xtask study a --one 3", "3\n");
        assert_eq!(more, format!("{new}\n## `cargo xtask study a --one 3`\n\n3\n"));
    }

    #[test]
    fn days_are_dates() {
        assert_eq!(
            [0, 59, 11_016, 20_785].map(date),
            ["1970-01-01", "1970-03-01", "2000-02-29", "2026-11-28"]
        );
    }

    #[test]
    fn other_text_of_the_document_is_unchanged() {
        let marked = |inside: &str| format!("<!-- study one: begin -->{inside}<!-- study one: end -->");
        let other = "<!-- study two: begin -->x<!-- study two: end -->";
        let text = format!("# A\n\n{}\n\nmore\n{other}", marked("\nold\n"));
        let new = published(&text, "one", "| a |\n").expect("markers");
        assert_eq!(new, format!("# A\n\n{}\n\nmore\n{other}", marked("\n\n| a |\n\n")));
        assert!(published("no markers", "one", "x").is_none());
        for part in ["reliability", "unseen tuning", "unseen locked", "unseen locked-2", "unseen locked-5"] {
            let document = include_str!("../../results/reliability.md");
            assert!(published(document, part, "").is_some(), "{part}");
        }
    }
}
