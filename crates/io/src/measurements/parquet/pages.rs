//! The offsets and lengths that the library uses are checked against the file here, so that one that was cut or altered is refused: bytes beyond its end, and pages whose
//! dictionary is missing.

use ::parquet::basic::Encoding;
use ::parquet::column::page::{Page, PageMetadata, PageReader};
use ::parquet::errors::{ParquetError, Result};
use ::parquet::file::metadata::ColumnChunkMetaData;
use ::parquet::file::reader::{ChunkReader, Length};
use bytes::Bytes;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};

/// A file that is never read beyond its end.
pub(super) struct Bounded {
    pub file: File,
    pub size: u64,
}

/// The file from somewhere on; its end is an error.
pub(super) struct Onwards(File);

impl Read for Onwards {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        match self.0.read(into)? {
            0 if !into.is_empty() => Err(ErrorKind::UnexpectedEof.into()),
            count => Ok(count),
        }
    }
}

impl Length for Bounded {
    fn len(&self) -> u64 {
        self.size
    }
}

impl ChunkReader for Bounded {
    type T = BufReader<Onwards>;

    fn get_read(&self, start: u64) -> Result<Self::T> {
        let mut file = self.file.try_clone()?;
        file.seek(SeekFrom::Start(start))?;
        Ok(BufReader::new(Onwards(file)))
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes> {
        if start.checked_add(length as u64).is_none_or(|end| end > self.size) {
            return Err(ParquetError::EOF(format!("{length} bytes from {start} on are more than there are")));
        }
        let mut file = self.file.try_clone()?;
        file.seek(SeekFrom::Start(start))?;
        let mut bytes = vec![0; length];
        file.read_exact(&mut bytes)?;
        Ok(bytes.into())
    }
}

/// Whether the declared place of a column of a row group is inside a file of this size.
pub(super) fn lies_in(column: &ColumnChunkMetaData, size: u64) -> bool {
    let start = column.dictionary_page_offset().unwrap_or(column.data_page_offset());
    let end = start.checked_add(column.compressed_size());
    column.data_page_offset() >= 0
        && start >= 0
        && column.compressed_size() >= 0
        && end.is_some_and(|end| end.cast_unsigned() <= size)
}

/// Pages of a column; a page that needs a dictionary has one.
pub(super) struct Pages {
    pub inner: Box<dyn PageReader>,
    /// Whether there was a dictionary.
    pub known: bool,
    /// A page that was skipped and is requested now.
    pub late: Option<Page>,
}

impl Iterator for Pages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        let page = self.inner.get_next_page()?;
        match &page {
            Some(Page::DictionaryPage { .. }) => self.known = true,
            Some(page) if !self.known && asks(page) => {
                self.late = self.inner.take_deferred_dictionary()?;
                self.known = self.late.is_some();
                if !self.known {
                    return Err(ParquetError::General(
                        "a page asks for a dictionary that is not there".into(),
                    ));
                }
            }
            _ => {}
        }
        Ok(page)
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.inner.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.inner.skip_next_page()
    }

    fn supports_deferred_dictionary(&self) -> bool {
        self.inner.supports_deferred_dictionary()
    }

    fn take_deferred_dictionary(&mut self) -> Result<Option<Page>> {
        if let Some(late) = self.late.take() {
            return Ok(Some(late));
        }
        let page = self.inner.take_deferred_dictionary()?;
        self.known |= page.is_some();
        Ok(page)
    }

    fn at_record_boundary(&mut self) -> Result<bool> {
        self.inner.at_record_boundary()
    }
}

/// Whether the values of a page are places in a dictionary.
fn asks(page: &Page) -> bool {
    !matches!(page, Page::DictionaryPage { .. })
        && matches!(page.encoding(), Encoding::RLE_DICTIONARY | Encoding::PLAIN_DICTIONARY)
}
