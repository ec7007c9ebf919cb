//! The part of `docs/reliability.md` that this study writes, between two markers; other text is not changed.

use std::error::Error;
use std::fs;
use std::path::Path;

const BEGIN: &str = "<!-- study reliability: begin -->";
const END: &str = "<!-- study reliability: end -->";

/// Writes the generated part.
pub fn write(tables: &str) -> Result<(), Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reliability.md");
    let text = fs::read_to_string(&path)?;
    let replaced =
        replaced(&text, tables).ok_or_else(|| format!("{}: the markers are gone", path.display()))?;
    fs::write(&path, replaced)?;
    Ok(())
}

fn replaced(text: &str, tables: &str) -> Option<String> {
    let (before, rest) = text.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n\n{}\n\n{END}{after}", tables.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_around_is_left_alone() {
        let text = format!("# A\n\n{BEGIN}\nold\n{END}\n\nmore\n");
        let new = replaced(&text, "| a |\n").expect("markers");
        assert_eq!(new, format!("# A\n\n{BEGIN}\n\n| a |\n\n{END}\n\nmore\n"));
        assert!(replaced("no markers", "x").is_none());
    }

    #[test]
    fn the_document_has_its_markers() {
        assert!(replaced(include_str!("../../../../docs/reliability.md"), "").is_some());
    }
}
