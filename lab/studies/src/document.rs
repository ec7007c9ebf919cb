//! The parts of `docs/reliability.md` that a study writes, each between two markers; other text is not changed.

use std::error::Error;
use std::fs;
use std::path::Path;

/// Writes the generated part of this name.
pub fn write(part: &str, tables: &str) -> Result<(), Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reliability.md");
    let text = fs::read_to_string(&path)?;
    let replaced = replaced(&text, part, tables)
        .ok_or_else(|| format!("{}: the markers of `{part}` are gone", path.display()))?;
    fs::write(&path, replaced)?;
    Ok(())
}

fn replaced(text: &str, part: &str, tables: &str) -> Option<String> {
    let (begin, end) = (format!("<!-- study {part}: begin -->"), format!("<!-- study {part}: end -->"));
    let (before, rest) = text.split_once(&begin)?;
    let (_, after) = rest.split_once(&end)?;
    Some(format!("{before}{begin}\n\n{}\n\n{end}{after}", tables.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_around_is_left_alone() {
        let marked = |inside: &str| format!("<!-- study one: begin -->{inside}<!-- study one: end -->");
        let other = "<!-- study two: begin -->x<!-- study two: end -->";
        let text = format!("# A\n\n{}\n\nmore\n{other}", marked("\nold\n"));
        let new = replaced(&text, "one", "| a |\n").expect("markers");
        assert_eq!(new, format!("# A\n\n{}\n\nmore\n{other}", marked("\n\n| a |\n\n")));
        assert!(replaced("no markers", "one", "x").is_none());
    }

    #[test]
    fn the_document_has_its_markers() {
        for part in ["reliability", "unseen tuning", "unseen locked", "unseen locked-2", "unseen locked-5"] {
            assert!(replaced(include_str!("../../../docs/reliability.md"), part, "").is_some(), "{part}");
        }
    }
}
