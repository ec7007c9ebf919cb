//! Lines of a text with their places.

use std::ops::Range;

/// A line without its end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line<'t> {
    pub(crate) bytes: &'t [u8],
    /// Offset of its first byte.
    pub(crate) start: usize,
    /// From 1.
    pub(crate) number: usize,
}

impl<'t> Line<'t> {
    /// Without blanks around it.
    pub(crate) fn trimmed(&self) -> &'t [u8] {
        self.bytes.trim_ascii()
    }

    /// What follows a word at its beginning, if that is there.
    pub(crate) fn after(&self, word: &str) -> Option<&'t [u8]> {
        let (head, rest) = self.trimmed().split_at_checked(word.len())?;
        head.eq_ignore_ascii_case(word.as_bytes()).then_some(rest)
    }

    /// Places of the parts between commas, without blanks, from this byte of the line on.
    pub(crate) fn fields(&self, from: usize) -> Vec<Range<usize>> {
        let mut fields = Vec::new();
        let mut at = from;
        for part in self.bytes[from..].split(|&byte| byte == b',') {
            let lead = part.len() - part.trim_ascii_start().len();
            let start = self.start + at + lead;
            fields.push(start..start + part.trim_ascii().len());
            at += part.len() + 1;
        }
        fields
    }
}

/// All lines; they end with CR LF, LF or CR.
pub(crate) fn lines(text: &[u8]) -> Vec<Line<'_>> {
    let mut found = Vec::new();
    let (mut start, mut number) = (if text.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 }, 1);
    while start < text.len() {
        let length = text[start..].iter().take_while(|&&byte| byte != b'\n' && byte != b'\r').count();
        let end = start + length;
        found.push(Line { bytes: &text[start..end], start, number });
        let both = text[end..].starts_with(b"\r\n");
        start = end + if both { 2 } else { 1 };
        number += 1;
    }
    found
}
