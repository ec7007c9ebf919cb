//! The offsets and lengths that the library uses are checked against the file here, so that one that was cut or altered is refused: bytes beyond its end, pages whose
//! dictionary is missing, and pages that unpack to more than a table may take, before anything is allocated for them.

use ::parquet::basic::Encoding;
use ::parquet::column::page::{Page, PageMetadata, PageReader};
use ::parquet::errors::{ParquetError, Result};
use ::parquet::file::metadata::ColumnChunkMetaData;
use ::parquet::file::reader::{ChunkReader, Length};
use bytes::Bytes;
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A file that is never read beyond its end.
pub(super) struct Bounded {
    pub file: File,
    pub size: u64,
    /// Bytes that a page unpacks to at most.
    pub page: Arc<AtomicU64>,
}

/// Of all pages that are in memory at once.
const MOST: u64 = 512 << 20;

/// Of a page, however many columns there are: writers make them of a megabyte or so.
const LEAST: u64 = 4 << 20;

/// What a page may unpack to where so many columns are read side by side.
pub(super) fn largest_page(columns: usize) -> u64 {
    (MOST / columns.max(1) as u64).max(LEAST)
}

/// The unpacked size that the header of a page declares, where these bytes begin one: a compact structure of its type, this size and the packed
/// one, which are numbered one to three.
fn unpacked_size(bytes: &[u8]) -> Option<i64> {
    let mut rest = bytes;
    let mut number = || {
        let (&[0x15], behind) = rest.split_first_chunk::<1>()? else { return None };
        let mut value = 0u64;
        for (k, byte) in behind.iter().take(10).enumerate() {
            value |= u64::from(byte & 0x7f).checked_shl(7 * k as u32)?;
            if byte & 0x80 == 0 {
                rest = &behind[k + 1..];
                return Some((value >> 1).cast_signed() ^ -(value & 1).cast_signed());
            }
        }
        None
    };
    let (_, unpacked, _) = (number()?, number()?, number()?);
    Some(unpacked)
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
        let mut read = BufReader::new(Onwards(file));
        let size = read.fill_buf().ok().and_then(unpacked_size).unwrap_or(0);
        let most = self.page.load(Ordering::Relaxed);
        if u64::try_from(size).is_ok_and(|size| size > most) {
            let most = most >> 20;
            return Err(ParquetError::General(format!("a page unpacks to more than {most} MiB")));
        }
        Ok(read)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_a_page_is_read_from_its_header() {
        // Type 0, 2^31 - 1 bytes unpacked, 5 packed.
        let header = [0x15, 0x00, 0x15, 0xfe, 0xff, 0xff, 0xff, 0x0f, 0x15, 0x0a, 0x2c];
        assert_eq!(unpacked_size(&header), Some(i64::from(i32::MAX)));
        assert_eq!(unpacked_size(&header[..6]), None);
        assert_eq!(unpacked_size(b"PAR1"), None);
        assert_eq!((largest_page(1), largest_page(1000)), (512 << 20, 4 << 20));
    }
}
