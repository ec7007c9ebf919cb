//! The lines of a table, out of large blocks of memory.
//!
//! Bytes are read a quarter of a megabyte at a time, checked to be UTF-8 and cut at line ends; nothing is
//! copied or allocated for a line.

use crate::IoError;
use crate::text::other_encoding;
use memchr::{memchr, memrchr};
use std::fs::File;
use std::io::{Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

const BLOCK: usize = 256 << 10;

/// No line of a table is longer.
const LONGEST_LINE: usize = 1 << 20;

/// Where the bytes are.
#[derive(Debug)]
enum Bytes {
    /// In a file, of which the first ones were looked at.
    File { head: Cursor<Vec<u8>>, rest: File },
    /// A table that was written anew.
    Memory(Cursor<Vec<u8>>),
}

impl Bytes {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        match self {
            Bytes::File { head, rest } => match head.read(into)? {
                0 => rest.read(into),
                count => Ok(count),
            },
            Bytes::Memory(bytes) => bytes.read(into),
        }
    }

    fn seek(&mut self, to: u64) -> std::io::Result<u64> {
        match self {
            Bytes::File { head, rest } => {
                head.set_position(head.get_ref().len() as u64);
                rest.seek(SeekFrom::Start(to))
            }
            Bytes::Memory(bytes) => bytes.seek(SeekFrom::Start(to)),
        }
    }
}

/// A file, line by line.
#[derive(Debug)]
pub(crate) struct Lines {
    file: PathBuf,
    source: Bytes,
    buffer: Vec<u8>,
    /// The next line begins here.
    start: usize,
    /// Whole lines, known to be UTF-8, end here.
    whole: usize,
    /// Bytes read end here.
    filled: usize,
    /// So many bytes of the file stand in front of that.
    read: u64,
    /// Number of the line returned last.
    line: u64,
    ended: bool,
    first: bool,
}

impl Lines {
    pub fn open(path: &Path) -> Result<Self, IoError> {
        let mut rest = File::open(path).map_err(|error| IoError::read(path, error))?;
        let mut head = Vec::new();
        (&mut rest).take(BLOCK as u64).read_to_end(&mut head).map_err(|error| IoError::read(path, error))?;
        Ok(Lines::over(path, Bytes::File { head: Cursor::new(head), rest }))
    }

    fn over(path: &Path, source: Bytes) -> Self {
        Lines {
            file: path.into(),
            source,
            buffer: vec![0; BLOCK],
            start: 0,
            whole: 0,
            filled: 0,
            read: 0,
            line: 0,
            ended: false,
            first: true,
        }
    }

    /// The first bytes, before a line is read, and whether they are all.
    pub fn head(&self) -> (&[u8], bool) {
        match &self.source {
            Bytes::File { head, .. } => (head.get_ref(), head.get_ref().len() < BLOCK),
            Bytes::Memory(bytes) => (bytes.get_ref(), true),
        }
    }

    /// All bytes, before a line is read; at most so many.
    ///
    /// # Errors
    /// When the file cannot be read or has more.
    pub fn all(&mut self, most: u64) -> Result<Vec<u8>, IoError> {
        match &mut self.source {
            Bytes::Memory(bytes) => Ok(std::mem::take(bytes.get_mut())),
            Bytes::File { head, rest } => {
                let mut all = std::mem::take(head.get_mut());
                rest.take(most).read_to_end(&mut all).map_err(|error| IoError::read(&self.file, error))?;
                if all.len() as u64 > most {
                    let message = format!(
                        "is larger than {} MiB, and not a comma-separated table in UTF-8 with decimal points; export it as one",
                        most >> 20
                    );
                    return Err(IoError::file(&self.file, message));
                }
                Ok(all)
            }
        }
    }

    /// Lines of a text in place of the file's.
    #[must_use]
    pub fn replaced(self, text: Vec<u8>) -> Self {
        Lines::over(&self.file, Bytes::Memory(Cursor::new(text)))
    }

    /// The text begins with a line that the file has not: the next line is number 0.
    pub fn begin_before(&mut self) {
        self.line = u64::MAX;
    }

    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Size of the file, bytes; zero where it has none.
    pub fn size(&self) -> u64 {
        match &self.source {
            Bytes::File { rest, .. } => rest.metadata().map_or(0, |metadata| metadata.len()),
            Bytes::Memory(bytes) => bytes.get_ref().len() as u64,
        }
    }

    /// How many bytes of the file have been handed out.
    pub fn handed_out(&self) -> u64 {
        self.read - (self.filled - self.start) as u64
    }

    /// Goes on behind the line that this byte belongs to. Numbers of lines mean nothing from here on.
    pub fn jump(&mut self, to: u64) -> Result<(), IoError> {
        self.source.seek(to).map_err(|error| IoError::read(&self.file, error))?;
        (self.start, self.whole, self.filled) = (0, 0, 0);
        (self.read, self.ended, self.first) = (to, false, false);
        self.next().map(|_| ())
    }

    /// The next line that is neither blank nor a comment, with its number and without its end.
    pub fn next(&mut self) -> Result<Option<(u64, &[u8])>, IoError> {
        loop {
            if self.start == self.whole {
                self.fill()?;
                if self.start == self.whole {
                    return Ok(None);
                }
            }
            let rest = &self.buffer[self.start..self.whole];
            let (length, step) = memchr(b'\n', rest).map_or((rest.len(), rest.len()), |at| (at, at + 1));
            let from = self.start;
            self.start += step;
            self.line = self.line.wrapping_add(1);
            if length > LONGEST_LINE {
                return Err(self.too_long(self.line));
            }
            let mut line = &self.buffer[from..from + length];
            if let [before @ .., b'\r'] = line {
                line = before;
            }
            match line.iter().find(|byte| !matches!(byte, b' ' | b'\t')) {
                None | Some(b'#') => {}
                Some(_) => {
                    let end = from + line.len();
                    return Ok(Some((self.line, &self.buffer[from..end])));
                }
            }
        }
    }

    fn fill(&mut self) -> Result<(), IoError> {
        self.buffer.copy_within(self.start..self.filled, 0);
        self.filled -= self.start;
        (self.start, self.whole) = (0, 0);
        while !self.ended {
            if self.filled == self.buffer.len() {
                if self.filled > LONGEST_LINE {
                    return Err(self.too_long(self.line.wrapping_add(1)));
                }
                self.buffer.resize(2 * self.filled, 0);
            }
            match self.source.read(&mut self.buffer[self.filled..]) {
                Ok(0) => self.ended = true,
                Ok(count) => {
                    let new = self.filled;
                    self.filled += count;
                    self.read += count as u64;
                    if let Some(at) = memrchr(b'\n', &self.buffer[new..self.filled]) {
                        self.whole = new + at + 1;
                        break;
                    }
                }
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(IoError::read(&self.file, error)),
            }
        }
        if self.ended {
            self.whole = self.filled;
        }
        if self.first {
            self.first = false;
            if let Some(message) = other_encoding(&self.buffer[..self.filled]) {
                return Err(IoError::file(&self.file, message));
            }
            if self.buffer[..self.whole].starts_with(b"\xef\xbb\xbf") {
                self.start = 3;
            }
        }
        match std::str::from_utf8(&self.buffer[self.start..self.whole]) {
            Ok(_) => Ok(()),
            Err(error) => {
                let at = self.start + error.valid_up_to();
                let before = &self.buffer[self.start..at];
                let line =
                    self.line.wrapping_add(1) + before.iter().filter(|&&byte| byte == b'\n').count() as u64;
                let in_line = before.len() - memrchr(b'\n', before).map_or(0, |k| k + 1) + 1;
                let message = format!(
                    "byte {in_line} of the line is 0x{:02X}, which is not UTF-8; save the file as UTF-8",
                    self.buffer[at]
                );
                Err(IoError::line(&self.file, line, message))
            }
        }
    }

    fn too_long(&self, line: u64) -> IoError {
        IoError::line(&self.file, line, "the line is longer than 1 MiB; this is no table of measurements")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8]) -> Result<Vec<(u64, String)>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("d.csv");
        std::fs::write(&path, bytes).unwrap();
        let mut lines = Lines::open(&path).unwrap();
        let mut all = Vec::new();
        loop {
            match lines.next() {
                Ok(Some((line, bytes))) => all.push((line, String::from_utf8(bytes.to_vec()).unwrap())),
                Ok(None) => return Ok(all),
                Err(error) => {
                    return Err(error.to_string().replace(&format!("{}/", folder.path().display()), ""));
                }
            }
        }
    }

    #[test]
    fn comments_blanks_and_line_ends() {
        let expected = vec![(2, "a,b".to_string()), (5, "1,2".into()), (6, "3,4".into())];
        assert_eq!(lines(b"\xef\xbb\xbf# c\na,b\r\n \t\r\n  # d\n1,2\n3,4").unwrap(), expected);
        assert_eq!(lines(b"").unwrap(), []);
        assert_eq!(lines(b"\xef\xbb\xbf").unwrap(), []);
        assert_eq!(lines(b"\n\n").unwrap(), []);
    }

    #[test]
    fn blocks_are_joined() {
        let mut bytes = Vec::new();
        for k in 0..200_000 {
            bytes.extend_from_slice(format!("{k},é\n").as_bytes());
        }
        let all = lines(&bytes).unwrap();
        assert_eq!(all.len(), 200_000);
        assert!(
            all.iter()
                .enumerate()
                .all(|(k, (line, text))| *line == k as u64 + 1 && *text == format!("{k},é"))
        );
    }

    #[test]
    fn endless_lines_and_other_encodings() {
        assert_eq!(
            lines(&[b"a\n".to_vec(), vec![b'7'; 3 << 20]].concat()).unwrap_err(),
            "d.csv:2: the line is longer than 1 MiB; this is no table of measurements"
        );
        assert_eq!(
            lines(b"a,b\n1,2\n3,\xff\n").unwrap_err(),
            "d.csv:3: byte 3 of the line is 0xFF, which is not UTF-8; save the file as UTF-8"
        );
        assert_eq!(lines(b"\xff\xfea\0").unwrap_err(), "d.csv: is UTF-16; save the file as UTF-8");
        assert!(lines(b"PAR1....").unwrap_err().contains("Parquet"));
        assert_eq!(lines(&vec![b'x'; 1 << 20]).unwrap().len(), 1);
    }
}
