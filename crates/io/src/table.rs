//! Tables as CSV: numbers with the fewest digits that read back to the same number, nothing for a NaN.

use crate::{IoError, WholeFile};
use std::io::Write;
use std::path::Path;

/// What formulas of spreadsheets begin with.
const FORMULA: [char; 4] = ['=', '+', '-', '@'];

/// A cell as it was meant, without the apostrophe that [`TableWriter::text`] puts in front of a formula.
pub(crate) fn unprefixed(text: &str) -> &str {
    text.strip_prefix('\'').filter(|rest| rest.starts_with(FORMULA)).unwrap_or(text)
}

/// Writes a table row by row into a file that appears with [`TableWriter::finish`].
#[derive(Debug)]
pub(crate) struct TableWriter {
    file: WholeFile,
    line: Vec<u8>,
}

impl TableWriter {
    pub fn create(path: &Path, header: &[String]) -> Result<Self, IoError> {
        let mut table = TableWriter { file: WholeFile::create(path)?, line: Vec::new() };
        header.iter().for_each(|name| table.text(name));
        table.end_row()?;
        Ok(table)
    }

    pub fn number(&mut self, value: f64) {
        if !value.is_nan() {
            // Writing to memory cannot fail. `{:?}` is the shortest form, with an exponent where that is shorter.
            let _ = write!(self.line, "{value:?}");
        }
        self.line.push(b',');
    }

    pub fn integer(&mut self, value: i64) {
        let _ = write!(self.line, "{value}");
        self.line.push(b',');
    }

    /// A text that a spreadsheet would take for a formula gets an apostrophe in front (OWASP, CSV injection); see [`unprefixed`].
    pub fn text(&mut self, text: &str) {
        let prefix = if text.starts_with(FORMULA) { "'" } else { "" };
        if text.contains([',', '"', '\n', '\r', '#']) {
            let _ = write!(self.line, "\"{prefix}{}\"", text.replace('"', "\"\""));
        } else {
            let _ = write!(self.line, "{prefix}{text}");
        }
        self.line.push(b',');
    }

    pub fn end_row(&mut self) -> Result<(), IoError> {
        self.line.pop();
        self.line.push(b'\n');
        self.file.write_all(&self.line).map_err(|error| self.file.refused(&error))?;
        self.line.clear();
        Ok(())
    }

    pub fn into_file(self) -> WholeFile {
        self.file
    }

    pub fn finish(self) -> Result<(), IoError> {
        self.file.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_shortest_and_quoted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let mut table = TableWriter::create(&path, &["a[m]".into(), "b".into(), "c".into()]).unwrap();
        table.number(0.1 + 0.2);
        table.number(f64::NAN);
        table.text("x,\"y\"");
        table.end_row().unwrap();
        table.number(1e300);
        table.integer(-3);
        table.number(-0.5);
        table.end_row().unwrap();
        assert!(!path.exists());
        table.finish().unwrap();
        let formula = folder.path().join("f.csv");
        let header = ["=1+1", "+x[m]", "-x", "@x", "'x", "-1,\"2\""].map(String::from);
        TableWriter::create(&formula, &header).unwrap().finish().unwrap();
        let written = std::fs::read_to_string(&formula).unwrap();
        assert_eq!(written, "'=1+1,'+x[m],'-x,'@x,'x,\"'-1,\"\"2\"\"\"\n");
        assert_eq!((unprefixed("'=1+1"), unprefixed("'x"), unprefixed("-x")), ("=1+1", "'x", "-x"));
        let expected = "a[m],b,c\n0.30000000000000004,,\"x,\"\"y\"\"\"\n1e300,-3,-0.5\n";
        assert_eq!(std::fs::read_to_string(&path).unwrap(), expected);
    }
}
