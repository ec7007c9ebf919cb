//! In which encoding a text is.

use std::borrow::Cow;

/// Encodings that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Utf8,
    Utf16Little,
    Utf16Big,
    /// One byte a character: what Western spreadsheets write that do not write UTF-8.
    Windows1252,
}

impl Encoding {
    /// The encoding of a text that begins like this; none where it is no text.
    pub fn of(head: &[u8], whole: bool) -> Option<Encoding> {
        match head {
            [0xff, 0xfe, ..] => return Some(Encoding::Utf16Little),
            [0xfe, 0xff, ..] => return Some(Encoding::Utf16Big),
            [b'P', b'K', 3, 4, ..] | [0x1f, 0x8b, ..] | [b'P', b'A', b'R', b'1', ..] => return None,
            _ => {}
        }
        if head.contains(&0) {
            return without_mark(head);
        }
        match std::str::from_utf8(head) {
            Ok(_) => Some(Encoding::Utf8),
            // A block may end within a character.
            Err(error) if error.error_len().is_none() && !whole => Some(Encoding::Utf8),
            Err(_) => head.iter().all(|&byte| western(byte)).then_some(Encoding::Windows1252),
        }
    }

    /// The text, without a byte order mark.
    pub fn decode(self, bytes: &[u8]) -> Cow<'_, str> {
        let wide = |of: fn([u8; 2]) -> u16| {
            let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| of([pair[0], pair[1]])).collect();
            String::from_utf16_lossy(&units)
        };
        let text = match self {
            Encoding::Utf8 => String::from_utf8_lossy(bytes),
            Encoding::Utf16Little => Cow::Owned(wide(u16::from_le_bytes)),
            Encoding::Utf16Big => Cow::Owned(wide(u16::from_be_bytes)),
            Encoding::Windows1252 => Cow::Owned(bytes.iter().map(|&byte| character(byte)).collect()),
        };
        match text.strip_prefix('\u{feff}') {
            Some(rest) => Cow::Owned(rest.to_owned()),
            None => text,
        }
    }
}

/// UTF-16 without a mark: every second byte of ASCII is zero.
fn without_mark(head: &[u8]) -> Option<Encoding> {
    let pairs = head.len() / 2;
    let zeros = |at: usize| head.chunks_exact(2).filter(|pair| pair[at] == 0).count();
    match (zeros(0), zeros(1)) {
        (0, odd) if 10 * odd >= 9 * pairs && pairs > 4 => Some(Encoding::Utf16Little),
        (even, 0) if 10 * even >= 9 * pairs && pairs > 4 => Some(Encoding::Utf16Big),
        _ => None,
    }
}

/// Bytes of Western text: printable ASCII, white space, dashes and quotes, letters with accents, `°`, `µ`, `²`, `·`, `±`.
fn western(byte: u8) -> bool {
    matches!(byte, b'\t' | b'\n' | b'\r' | 0x20..=0x7e | 0x91..=0x97 | 0xa0 | 0xb0..=0xb3 | 0xb5 | 0xb7 | 0xc0..=0xfc)
}

fn character(byte: u8) -> char {
    match byte {
        0x91 | 0x92 => '\'',
        0x93 | 0x94 => '"',
        0x96 | 0x97 => '\u{2013}',
        byte => char::from(byte),
    }
}
