//! Where the named elements of an XML text stand, and how deep it nests.
//!
//! The URDF library keeps no positions and recurses into nested elements; this scanner reads tags only, so
//! that messages have a line and a hostile file cannot exhaust the stack.

use std::ops::Range;

/// Tags nest no deeper than this in any robot description.
const DEEPEST: usize = 200;

/// An opening tag: its element, its `name` attribute, where it begins and ends, and its nesting depth.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Tag<'a> {
    pub element: &'a str,
    pub name: Option<&'a str>,
    pub at: usize,
    /// Behind its `>`.
    pub end: usize,
    pub depth: usize,
}

/// The opening tags of a text in their order.
///
/// # Errors
/// The offset at which the text nests too deeply or a tag does not end, and what is wrong.
pub(super) fn tags(text: &str) -> Result<Vec<Tag<'_>>, (usize, String)> {
    let mut tags = Vec::new();
    let (mut at, mut depth) = (0, 0usize);
    while let Some(found) = text[at..].find('<') {
        let start = at + found;
        let rest = &text[start..];
        let ends: Option<(usize, &str)> = if rest.starts_with("<!--") {
            rest.find("-->").map(|end| (end + 3, ""))
        } else if rest.starts_with("<![CDATA[") {
            rest.find("]]>").map(|end| (end + 3, ""))
        } else if rest.starts_with("<!") {
            return Err((start, "document type declarations are not read; remove the `<!…>`".into()));
        } else {
            tag_end(rest).map(|end| (end + 1, &rest[1..end]))
        };
        let Some((length, inner)) = ends else {
            return Err((start, "is not XML: a `<` without its `>`".into()));
        };
        if inner.starts_with('/') {
            depth = depth.saturating_sub(1);
        } else if !inner.is_empty() && !inner.starts_with('?') {
            let element = inner.split(|c: char| c.is_whitespace() || c == '/').next().unwrap_or("");
            let name = attribute(inner, "name").map(|value| &inner[value]);
            tags.push(Tag { element, name, at: start, end: start + length, depth });
            if !inner.ends_with('/') {
                depth += 1;
                if depth > DEEPEST {
                    return Err((
                        start,
                        format!("elements nest more than {DEEPEST} deep; this is not a URDF"),
                    ));
                }
            }
        }
        at = start + length;
    }
    Ok(tags)
}

/// Where the element of this kind and name begins.
pub(super) fn place_of(tags: &[Tag<'_>], element: &str, name: &str) -> usize {
    tags.iter().find(|tag| tag.element == element && tag.name == Some(name)).map_or(0, |tag| tag.at)
}

/// The offset of the `>` that ends a tag, not counting those inside of quotes.
fn tag_end(tag: &str) -> Option<usize> {
    let mut quote = None;
    for (at, byte) in tag.bytes().enumerate() {
        match (quote, byte) {
            (None, b'>') => return Some(at),
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), byte) if open == byte => quote = None,
            _ => {}
        }
    }
    None
}

/// Place of the value of an attribute in a tag, without its quotes.
pub(super) fn attribute(tag: &str, wanted: &str) -> Option<Range<usize>> {
    let mut at = 0;
    while let Some(equals) = tag[at..].find('=') {
        let key = tag[at..at + equals].trim_end().rsplit(char::is_whitespace).next()?;
        let value = tag[at + equals + 1..].trim_start();
        let quote = value.chars().next().filter(|c| matches!(c, '"' | '\''))?;
        let begin = tag.len() - value.len() + 1;
        let end = begin + value[1..].find(quote)?;
        if key == wanted {
            return Some(begin..end);
        }
        at = end + 1;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_are_found() {
        let text = "<?xml?><!-- <joint name='no'/> --><robot name=\"r\">\n<joint type='a>b' name = 'j1'><axis/></joint></robot>";
        let found = tags(text).unwrap();
        let names: Vec<_> = found.iter().map(|tag| (tag.element, tag.name)).collect();
        assert_eq!(names, [("robot", Some("r")), ("joint", Some("j1")), ("axis", None)]);
        assert_eq!(found.iter().map(|tag| tag.depth).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(&text[found[2].at..found[2].end], "<axis/>");
        assert_eq!(attribute("a x = '1' y=\"2\"", "y"), Some(13..14));
        assert_eq!(place_of(&found, "joint", "j1"), text.find("<joint type").unwrap());
        assert!(tags(&"<a>".repeat(1000)).unwrap_err().1.contains("nest"));
        assert!(tags("<a").is_err());
        assert!(tags("<!DOCTYPE x>").is_err());
        assert_eq!(tags("").unwrap(), []);
    }
}
