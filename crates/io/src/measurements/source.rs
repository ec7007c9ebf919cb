//! Where the rows of a table come from: lines of text, or a Parquet file (feature `parquet`), which is recognised by its first bytes.

use super::lines::Lines;
#[cfg(feature = "parquet")]
use super::parquet::ParquetRows;
use super::row::RowReader;
use crate::IoError;
use std::borrow::Cow;
use std::path::Path;

/// A line of text and its number.
type Line<'a> = (u64, Cow<'a, [u8]>);

/// A table, row by row.
#[derive(Debug)]
pub(crate) enum Source {
    Text(Lines),
    #[cfg(feature = "parquet")]
    Parquet(Box<ParquetRows>),
}

impl Source {
    pub fn open(path: &Path) -> Result<Self, IoError> {
        #[cfg(feature = "parquet")]
        if super::parquet::is_parquet(path)? {
            return Ok(Source::Parquet(Box::new(ParquetRows::open(path)?)));
        }
        Ok(Source::Text(Lines::open(path)?))
    }

    /// The names of the columns as a line of text, and its number; none in an empty file.
    pub fn header(&mut self) -> Result<Option<Line<'_>>, IoError> {
        match self {
            Source::Text(lines) => Ok(lines.next()?.map(|(line, text)| (line, Cow::Borrowed(text)))),
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
            #[cfg(feature = "parquet")]
            Source::Parquet(rows) => rows.row(into),
        }
    }

    pub fn file(&self) -> &Path {
        match self {
            Source::Text(lines) => lines.file(),
            #[cfg(feature = "parquet")]
            Source::Parquet(rows) => rows.file(),
        }
    }

    /// Size of the file, bytes; zero where it has none.
    pub fn size(&self) -> u64 {
        match self {
            Source::Text(lines) => lines.size(),
            #[cfg(feature = "parquet")]
            Source::Parquet(rows) => rows.size(),
        }
    }

    /// How many bytes of the file have been handed out.
    pub fn handed_out(&self) -> u64 {
        match self {
            Source::Text(lines) => lines.handed_out(),
            #[cfg(feature = "parquet")]
            Source::Parquet(rows) => rows.handed_out(),
        }
    }

    /// Goes on behind the row that this byte belongs to.
    pub fn jump(&mut self, to: u64) -> Result<(), IoError> {
        match self {
            Source::Text(lines) => lines.jump(to),
            #[cfg(feature = "parquet")]
            Source::Parquet(rows) => rows.jump(to),
        }
    }
}
