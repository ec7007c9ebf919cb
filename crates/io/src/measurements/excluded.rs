//! Lines that are left out: `--exclude`.

use crate::IoError;
use std::path::Path;

/// The lines, ascending, and those of them that were met.
#[derive(Debug)]
pub(crate) struct Excluded {
    lines: Vec<u64>,
    met: Vec<u64>,
}

impl Excluded {
    pub fn new(lines: Vec<u64>) -> Self {
        Excluded { lines, met: Vec::new() }
    }

    /// Whether this line is left out.
    pub fn has(&mut self, line: u64) -> bool {
        let has = !self.lines.is_empty() && self.lines.binary_search(&line).is_ok();
        if has {
            self.met.push(line);
        }
        has
    }

    /// Refuses, at the end of a file, a line that was no row of it.
    pub fn all_met(&self, file: &Path) -> Result<(), IoError> {
        match self.lines.iter().find(|line| !self.met.contains(line)) {
            Some(&line) => {
                let words = "is to be left out (`--exclude`), and is no row of this file";
                Err(IoError::line(file, line, words))
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_is_no_row_is_named() {
        let mut excluded = Excluded::new(vec![3, 7]);
        assert!(excluded.has(3) && !excluded.has(4));
        let error = excluded.all_met(Path::new("d.csv")).unwrap_err().to_string();
        assert!(error.starts_with("d.csv:7: is to be left out"), "{error}");
        assert!(excluded.has(7) && excluded.all_met(Path::new("d.csv")).is_ok());
    }
}
