//! Tables as other programs write them: another encoding, separator or decimal mark, titles above the header, a row of units.
//!
//! ```text
//! first block of the file ──► Dialect::seen ──► none: the file is read as it is, line by line
//!                                          └──► some: the whole file is written anew in memory, line for line
//! ```
//!
//! A row of titles above the header completes names that it lacks or has twice; structures of KRL become columns; a comment above rows without a
//! header may name their columns.
//! Only what has one reading is written anew; a number such as `1.234` beside decimal commas is left to an error. Lines keep their numbers.

mod composed;
mod cut;
mod encoding;
mod in_cells;
mod krl;
mod named;
mod numbers;
mod rewrite;
mod sniff;
mod spaced;

use super::names::Names;
use crate::IoError;
use std::path::Path;

/// A rewritten table is held in memory; no campaign in a spreadsheet's dialect comes near this size.
pub(super) const LARGEST: u64 = 512 << 20;

/// How a file is written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dialect {
    encoding: encoding::Encoding,
    /// What separates cells.
    separator: char,
    /// Line of the header, from 0.
    header: usize,
    /// Line of a row of units below the header, from 0.
    units: Option<usize>,
    /// Lines above the header that complete its names, from 0, the nearest first.
    above: Vec<usize>,
    /// Whether cells may hold decimal commas, or marks between thousands.
    commas: bool,
    /// The unit that stands in every cell of a column.
    in_cells: Vec<Option<String>>,
    /// The rows are structures of a controller's language.
    structures: bool,
}

/// A table written anew, and what was remarkable about the file.
pub(super) struct Rewritten {
    pub text: Vec<u8>,
    pub remarks: Vec<String>,
    /// The header is no line of the file: the text has one line more.
    pub header_added: bool,
}

impl Dialect {
    /// How a file is written that begins like this; none where the plain reader reads it.
    pub fn seen(head: &[u8], whole: bool, names: &Names<'_>) -> Option<Dialect> {
        let encoding = encoding::Encoding::of(head, whole)?;
        sniff::dialect(&encoding.decode(head), encoding, whole, names)
    }

    /// The whole file as comma-separated text in UTF-8 with decimal points.
    ///
    /// # Errors
    /// Where a number has two readings.
    pub fn rewrite(&self, file: &Path, bytes: &[u8], names: &Names<'_>) -> Result<Rewritten, IoError> {
        let text = self.encoding.decode(bytes);
        if self.structures { krl::rewrite(file, &text) } else { rewrite::rewrite(self, file, &text, names) }
    }
}

/// Blank lines and comments.
pub(super) fn skipped(line: &str) -> bool {
    let line = line.trim_matches([' ', '\t']);
    line.is_empty() || line.starts_with('#')
}
