//! The tags of an XML text and the places of their attributes' values.

use crate::ControllerError;
use crate::error::syntax;
use std::ops::Range;

/// A tag.
#[derive(Debug, Clone)]
pub(super) struct Tag<'t> {
    pub(super) name: &'t str,
    /// `</…>`
    pub(super) closes: bool,
    attributes: Vec<(&'t str, Range<usize>)>,
    /// Behind the tag's name.
    pub(super) behind_name: usize,
    pub(super) line: usize,
}

impl Tag<'_> {
    /// The place of an attribute's value, between its quotes.
    pub(super) fn value(&self, name: &str) -> Option<Range<usize>> {
        self.attributes.iter().find(|(other, _)| *other == name).map(|(_, range)| range.clone())
    }

    /// An attribute's value as it stands.
    pub(super) fn shown(&self, text: &[u8], name: &str) -> Option<String> {
        self.value(name).map(|range| String::from_utf8_lossy(&text[range]).into_owned())
    }
}

/// All tags in order; comments, CDATA, instructions and declarations are passed over.
///
/// # Errors
/// When one of them is not closed, or a tag is none.
pub(super) fn tags(text: &[u8]) -> Result<Vec<Tag<'_>>, ControllerError> {
    let mut found = Vec::new();
    let mut at = 0;
    let mut line = 1;
    let mut counted = 0;
    while let Some(open) = find(text, at, b"<") {
        line += text[counted..open].iter().filter(|&&byte| byte == b'\n').count();
        counted = open;
        let passed: [(&[u8], &[u8]); 4] =
            [(b"<!--", b"-->"), (b"<![CDATA[", b"]]>"), (b"<?", b"?>"), (b"<!", b">")];
        if let Some((begin, end)) = passed.iter().find(|(begin, _)| text[open..].starts_with(begin)) {
            let close = find(text, open + begin.len(), end);
            let close =
                close.ok_or_else(|| syntax(text, open, "a comment or a declaration is not closed"))?;
            at = close + end.len();
            continue;
        }
        let (tag, behind) = tag(text, open, line)?;
        at = behind;
        found.push(tag);
    }
    Ok(found)
}

fn find(text: &[u8], from: usize, what: &[u8]) -> Option<usize> {
    text[from.min(text.len())..].windows(what.len()).position(|window| window == what).map(|at| from + at)
}

fn is_name(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b':' | b'-' | b'.')
}

fn word(text: &[u8], at: usize) -> &str {
    let length = text[at..].iter().take_while(|&&byte| is_name(byte)).count();
    std::str::from_utf8(&text[at..at + length]).unwrap_or("")
}

fn blanks(text: &[u8], at: usize) -> usize {
    at + text[at..].iter().take_while(|byte| byte.is_ascii_whitespace()).count()
}

fn tag(text: &[u8], open: usize, line: usize) -> Result<(Tag<'_>, usize), ControllerError> {
    let wrong = |at: usize| syntax(text, at, "this is no tag of XML");
    let closes = text.get(open + 1) == Some(&b'/');
    let start = open + 1 + usize::from(closes);
    let name = text.get(start..).map_or("", |_| word(text, start));
    if name.is_empty() {
        return Err(wrong(open));
    }
    let mut at = start + name.len();
    let mut tag = Tag { name, closes, attributes: Vec::new(), behind_name: at, line };
    loop {
        at = blanks(text, at);
        match text.get(at) {
            Some(b'>') => return Ok((tag, at + 1)),
            Some(b'/') if text.get(at + 1) == Some(&b'>') => return Ok((tag, at + 2)),
            None => return Err(wrong(open)),
            _ => {}
        }
        let name = word(text, at);
        at = blanks(text, at + name.len());
        if name.is_empty() || text.get(at) != Some(&b'=') {
            return Err(wrong(at.min(text.len())));
        }
        at = blanks(text, at + 1);
        let quote =
            text.get(at).copied().filter(|byte| matches!(byte, b'"' | b'\'')).ok_or_else(|| wrong(at))?;
        let length = text[at + 1..].iter().position(|&byte| byte == quote || byte == b'<');
        let end = length.map(|length| at + 1 + length).filter(|&end| text[end] == quote);
        let end = end.ok_or_else(|| syntax(text, at, "an attribute is not closed"))?;
        if tag.attributes.iter().any(|(other, _)| *other == name) {
            return Err(syntax(text, at, format!("the attribute `{name}` is there twice")));
        }
        tag.attributes.push((name, at + 1..end));
        at = end + 1;
    }
}
