//! Where the rows of a table come from: lines of text, a Parquet file (feature `parquet`), which is recognised by its first bytes, or memory.

use super::dialect::{self, Dialect};
use super::lines::Lines;
use super::memory::{MemoryRows, MemoryTable};
use super::names::Names;
#[cfg(feature = "parquet")]
use super::parquet::ParquetRows;
use super::row::RowReader;
use super::sampled::Sample;
use super::workbook;
use crate::IoError;
use std::borrow::Cow;
use std::path::Path;

/// A line of text and its number.
type Line<'a> = (u64, Cow<'a, [u8]>);

/// A table, row by row.
#[derive(Debug)]
pub(crate) enum Source {
    Text(Lines),
    Memory(Box<MemoryRows>),
    #[cfg(feature = "parquet")]
    Parquet(Box<ParquetRows>),
}

impl Source {
    /// Opens a file, whatever its dialect; with its first rows and what was remarkable about it.
    pub fn open(path: &Path, names: &Names<'_>) -> Result<(Self, Sample, Vec<String>), IoError> {
        #[cfg(feature = "parquet")]
        if super::parquet::is_parquet(path)? {
            return Ok((Source::Parquet(Box::new(ParquetRows::open(path)?)), Sample::default(), Vec::new()));
        }
        let mut lines = Lines::open(path)?;
        let mut remarks = Vec::new();
        if workbook::is_workbook(lines.head().0) {
            let bytes = lines.all(dialect::LARGEST)?;
            let (text, said) = workbook::lines(path, bytes, names)?;
            remarks.extend(said);
            lines = lines.replaced(text);
        }
        let (head, whole) = lines.head();
        if let Some(dialect) = Dialect::seen(head, whole, names) {
            let bytes = lines.all(dialect::LARGEST)?;
            let rewritten = dialect.rewrite(path, &bytes, names)?;
            remarks.extend(rewritten.remarks);
            lines = lines.replaced(rewritten.text);
            if rewritten.header_added {
                lines.begin_before();
            }
        }
        let (head, whole) = lines.head();
        let sample = Sample::of(head, whole);
        Ok((Source::Text(lines), sample, remarks))
    }

    /// Goes through a table in memory.
    pub fn memory(table: MemoryTable) -> Self {
        Source::Memory(Box::new(MemoryRows::new(table)))
    }

    /// The names of the columns as a line of text, and its number; none in an empty file.
    pub fn header(&mut self) -> Result<Option<Line<'_>>, IoError> {
        match self {
            Source::Text(lines) => Ok(lines.next()?.map(|(line, text)| (line, Cow::Borrowed(text)))),
            Source::Memory(rows) => Ok(Some((0, Cow::Owned(rows.header())))),
            #[cfg(feature = "parquet")]
            Source::Parquet(rows) => Ok(Some((0, Cow::Owned(rows.header())))),
        }
    }

    /// Reads the next row; about how many bytes of the file it takes, none at the end.
    pub fn row(&mut self, into: &mut RowReader) -> Result<Option<usize>, IoError> {
        match self {
            Source::Text(lines) => {
                let Some((line, text)) = lines.next()? else { return Ok(None) };
                into.read(line, text)?;
                Ok(Some(text.len() + 1))
            }
            Source::Memory(rows) => rows.row(into),
            #[cfg(feature = "parquet")]
            Source::Parquet(rows) => rows.row(into),
        }
    }

    pub fn file(&self) -> &Path {
        match self {
            Source::Text(lines) => lines.file(),
            Source::Memory(rows) => rows.file(),
            #[cfg(feature = "parquet")]
            Source::Parquet(rows) => rows.file(),
        }
    }

    /// Size of the file, bytes; zero where it has none.
    pub fn size(&self) -> u64 {
        match self {
            Source::Text(lines) => lines.size(),
            Source::Memory(rows) => rows.size(),
            #[cfg(feature = "parquet")]
            Source::Parquet(rows) => rows.size(),
        }
    }

    /// How many bytes of the file have been handed out.
    pub fn handed_out(&self) -> u64 {
        match self {
            Source::Text(lines) => lines.handed_out(),
            Source::Memory(rows) => rows.handed_out(),
            #[cfg(feature = "parquet")]
            Source::Parquet(rows) => rows.handed_out(),
        }
    }

    /// Goes on behind the row that this byte belongs to.
    pub fn jump(&mut self, to: u64) -> Result<(), IoError> {
        match self {
            Source::Text(lines) => lines.jump(to),
            Source::Memory(rows) => {
                rows.jump(to);
                Ok(())
            }
            #[cfg(feature = "parquet")]
            Source::Parquet(rows) => rows.jump(to),
        }
    }
}
