//! A text file in memory, with places given by line and character.

use crate::IoError;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// No description of a robot or a model comes near this size; what is larger is another kind of file.
const LARGEST_TEXT: u64 = 8 << 20;

/// A whole text and where it came from.
#[derive(Debug)]
pub(crate) struct Text {
    pub file: PathBuf,
    pub text: String,
}

/// Reads a UTF-8 text file of moderate size, without a byte order mark.
///
/// # Errors
/// When the file cannot be read, is very large, or is not UTF-8.
pub fn read_text(path: impl AsRef<Path>) -> Result<String, IoError> {
    Ok(Text::read(path.as_ref())?.text)
}

impl Text {
    /// Reads a UTF-8 file; a byte order mark at its front is dropped.
    pub fn read(path: &Path) -> Result<Text, IoError> {
        Text::read_up_to(path, LARGEST_TEXT)
    }

    /// Reads a UTF-8 file of at most this many bytes.
    pub fn read_up_to(path: &Path, largest: u64) -> Result<Text, IoError> {
        let mut bytes = Vec::new();
        File::open(path)
            .and_then(|file| file.take(largest + 1).read_to_end(&mut bytes))
            .map_err(|error| IoError::read(path, error))?;
        if bytes.len() as u64 > largest {
            let message = format!("is larger than {} MB; this is another kind of file", largest >> 20);
            return Err(IoError::file(path, message));
        }
        if let Some(message) = other_encoding(&bytes) {
            return Err(IoError::file(path, message));
        }
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").map(<[u8]>::to_vec).unwrap_or(bytes);
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Text { file: path.into(), text }),
            Err(error) => {
                let at = error.utf8_error().valid_up_to();
                let good = String::from_utf8_lossy(&error.as_bytes()[..at]).into_owned();
                let byte = error.as_bytes()[at];
                let text = Text { file: path.into(), text: good };
                Err(text.error(at, format!("byte 0x{byte:02X} is not UTF-8; save the file as UTF-8")))
            }
        }
    }

    /// Line and character of a byte offset, both from 1.
    pub fn place(&self, offset: usize) -> (u64, u64) {
        let mut offset = offset.min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let before = &self.text[..offset];
        let line = before.bytes().filter(|&b| b == b'\n').count() as u64 + 1;
        let start = before.rfind('\n').map_or(0, |k| k + 1);
        (line, before[start..].chars().count() as u64 + 1)
    }

    /// An error at a byte offset.
    pub fn error(&self, offset: usize, message: impl Into<String>) -> IoError {
        let (line, column) = self.place(offset);
        IoError::Text { file: self.file.clone(), line, column, message: message.into() }
    }
}

/// A message when the first bytes show another encoding than UTF-8.
pub(crate) fn other_encoding(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("is UTF-16; save the file as UTF-8"),
        [0x1f, 0x8b, ..] => Some("is compressed (gzip); unpack it first"),
        [b'P', b'K', 3, 4, ..] => Some("is a zip archive or a spreadsheet; export it as text (UTF-8) first"),
        [b'<', rest @ ..] if web_page(rest) => Some("is a web page; download the file itself"),
        [b'P', b'A', b'R', b'1', ..] => Some(
            "is a Parquet file, which this program was built without (cargo feature `parquet`); export it as CSV",
        ),
        _ => None,
    }
}

/// HTML, behind its first bracket.
fn web_page(rest: &[u8]) -> bool {
    [&b"!doctype html"[..], b"html"]
        .iter()
        .any(|tag| rest.get(..tag.len()).is_some_and(|r| r.eq_ignore_ascii_case(tag)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_characters() {
        let text = Text { file: "t".into(), text: "ab\nä€c\n".into() };
        assert_eq!(text.place(0), (1, 1));
        assert_eq!(text.place(3), (2, 1));
        assert_eq!(text.place(4), (2, 1)); // inside of ä
        assert_eq!(text.place(8), (2, 3));
        assert_eq!(text.place(99), (3, 1));
    }

    #[test]
    fn what_is_not_utf8_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.toml");
        std::fs::write(&path, b"name = \"a\"\nx = \"\xfc\"\n").unwrap();
        let message = Text::read(&path).unwrap_err().to_string();
        assert!(
            message.ends_with("robot.toml:2:6: byte 0xFC is not UTF-8; save the file as UTF-8"),
            "{message}"
        );
        std::fs::write(&path, b"\xef\xbb\xbfx = 1").unwrap();
        assert_eq!(Text::read(&path).unwrap().text, "x = 1");
        std::fs::write(&path, b"\xff\xfex\0").unwrap();
        let message = Text::read(&path).unwrap_err().to_string();
        assert!(message.ends_with("robot.toml: is UTF-16; save the file as UTF-8"), "{message}");
        let missing = Text::read(&folder.path().join("none.toml")).unwrap_err().to_string();
        assert!(missing.ends_with("none.toml: cannot be read: there is no such file"), "{missing}");
    }
}
