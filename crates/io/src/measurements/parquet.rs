//! Measurements in a Parquet file: columns under the names that a CSV's header has, `x[mm]` and so on, batch by batch out of one row group
//! after the other.
//!
//! A null and a NaN are an empty cell; a text in a column of numbers is read as a CSV's cell is. Rows count from one, and the schema is line 0:
//! `d.parquet:7: column `x[mm]` (3): …` is the seventh row.

mod pages;

use super::row::RowReader;
use super::taken::Cell;
use crate::IoError;
use ::parquet::basic::{ConvertedType, Type};
use ::parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use ::parquet::data_type::{ByteArray, DataType};
use ::parquet::errors::ParquetError;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::schema::types::ColumnDescriptor;
use pages::{Bounded, Pages, largest_page, lies_in};
use std::fs::File;
use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Rows that are in memory at once.
const BATCH: usize = 4096;

/// Whether a file begins as Parquet files do.
pub(crate) fn is_parquet(path: &Path) -> Result<bool, IoError> {
    // What comes through a pipe cannot be read again.
    if !path.is_file() && path.exists() {
        return Ok(false);
    }
    let mut first = Vec::with_capacity(4);
    let file = File::open(path).map_err(|error| IoError::read(path, error))?;
    file.take(4).read_to_end(&mut first).map_err(|error| IoError::read(path, error))?;
    Ok(first == b"PAR1")
}

/// Rows of a column that have been read.
#[derive(Debug)]
enum Batch {
    /// NaN: empty.
    Numbers(Vec<f64>),
    Texts(Vec<Option<ByteArray>>),
}

/// A file, row by row.
pub(crate) struct ParquetRows {
    file: PathBuf,
    bytes: u64,
    reader: SerializedFileReader<Bounded>,
    names: Vec<String>,
    /// Of unsigned integers.
    unsigned: Vec<bool>,
    /// Whether cells may be empty.
    optional: Vec<bool>,
    rows: u64,
    /// The row group that is opened next, and the columns of the one that is open.
    next_group: usize,
    columns: Vec<ColumnReader>,
    /// Rows of that group which have not been read.
    left: usize,
    batch: Vec<Batch>,
    /// Rows in the batch, and those of them that were handed out.
    filled: usize,
    used: usize,
    /// Number of the row that was handed out last.
    row: u64,
}

impl std::fmt::Debug for ParquetRows {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ParquetRows")
            .field("file", &self.file)
            .field("row", &self.row)
            .finish_non_exhaustive()
    }
}

/// What is wrong with a column as a whole; nothing where it is numbers or texts.
fn refused(column: &ColumnDescriptor) -> Option<&'static str> {
    use ConvertedType as Converted;
    if column.max_rep_level() > 0 || column.path().parts().len() > 1 {
        return Some("is a list or a group; a table of measurements has one number or text a cell");
    }
    let plain = match column.physical_type() {
        Type::DOUBLE | Type::FLOAT => true,
        Type::INT32 | Type::INT64 => !matches!(
            column.converted_type(),
            Converted::DECIMAL
                | Converted::DATE
                | Converted::TIME_MILLIS
                | Converted::TIME_MICROS
                | Converted::TIMESTAMP_MILLIS
                | Converted::TIMESTAMP_MICROS
        ),
        Type::BYTE_ARRAY => {
            matches!(column.converted_type(), Converted::NONE | Converted::UTF8 | Converted::ENUM)
        }
        _ => false,
    };
    // Times of nanoseconds have no converted type.
    let logical = column.logical_type_ref().is_some_and(|logical| {
        use ::parquet::basic::LogicalType as Logical;
        !matches!(logical, Logical::Integer(_) | Logical::String | Logical::Enum)
    });
    (!plain || logical).then_some(
        "holds neither plain numbers nor texts; write times as seconds, and directions as -1, 0 or 1",
    )
}

impl ParquetRows {
    pub fn open(path: &Path) -> Result<Self, IoError> {
        let source = File::open(path).map_err(|error| IoError::read(path, error))?;
        let bytes = source.metadata().map_or(0, |metadata| metadata.len());
        let page = Arc::new(AtomicU64::new(u64::MAX));
        let source = Bounded { file: source, size: bytes, page: page.clone() };
        let reader = caught(|| SerializedFileReader::new(source)).map_err(|error| wrong(path, &error))?;
        let mut chunks = reader.metadata().row_groups().iter().flat_map(|group| group.columns());
        if let Some(column) = chunks.find(|column| !lies_in(column, bytes)) {
            let name = super::cells::shown(&column.column_path().string());
            return Err(IoError::file(
                path,
                format!("cannot be read as Parquet: column `{name}` is not in it"),
            ));
        }
        let metadata = reader.metadata().file_metadata();
        let described = metadata.schema_descr().columns().to_vec();
        page.store(largest_page(described.len()), Ordering::Relaxed);
        for (k, column) in described.iter().enumerate() {
            if let Some(message) = refused(column) {
                return Err(IoError::Cell {
                    file: path.into(),
                    line: 0,
                    name: super::cells::shown(&column.path().string()),
                    number: k + 1,
                    message: message.into(),
                });
            }
        }
        let unsigned = |column: &ColumnDescriptor| {
            use ConvertedType as Converted;
            matches!(
                column.converted_type(),
                Converted::UINT_8 | Converted::UINT_16 | Converted::UINT_32 | Converted::UINT_64
            )
        };
        let batch = described.iter().map(|column| match column.physical_type() {
            Type::BYTE_ARRAY => Batch::Texts(Vec::new()),
            _ => Batch::Numbers(Vec::new()),
        });
        Ok(ParquetRows {
            file: path.into(),
            bytes,
            names: described.iter().map(|column| column.name().to_string()).collect(),
            unsigned: described.iter().map(|column| unsigned(column)).collect(),
            optional: described.iter().map(|column| column.max_def_level() > 0).collect(),
            batch: batch.collect(),
            rows: u64::try_from(metadata.num_rows()).unwrap_or(0),
            next_group: 0,
            columns: Vec::new(),
            left: 0,
            filled: 0,
            used: 0,
            row: 0,
            reader,
        })
    }

    /// The names of the columns as the header of a CSV.
    pub fn header(&self) -> Vec<u8> {
        let quoted = |name: &String| format!("\"{}\"", name.replace('"', "\"\""));
        self.names.iter().map(quoted).collect::<Vec<_>>().join(",").into_bytes()
    }

    pub fn file(&self) -> &Path {
        &self.file
    }

    pub fn size(&self) -> u64 {
        self.bytes
    }

    /// The fraction of the file that is read so far.
    pub fn handed_out(&self) -> u64 {
        (self.row as f64 / self.rows.max(1) as f64 * self.bytes as f64) as u64
    }

    /// Goes on behind the row that is as far in the file as this byte.
    pub fn jump(&mut self, to: u64) -> Result<(), IoError> {
        let row = (to as f64 / self.bytes.max(1) as f64 * self.rows as f64) as u64 + 1;
        (self.row, self.next_group, self.left, self.filled, self.used) = (0, 0, 0, 0, 0);
        self.columns.clear();
        while self.row < row {
            if self.left == 0 && !self.open_group()? {
                return Ok(());
            }
            let over = usize::try_from(row - self.row).unwrap_or(usize::MAX).min(self.left);
            // A group that is passed as a whole is not even looked into.
            if over < self.left {
                let file = &self.file;
                self.columns.iter_mut().try_for_each(|column| {
                    caught(|| skip(column, over)).map_err(|error| wrong(file, &error))
                })?;
            }
            self.left -= over;
            self.row += over as u64;
        }
        Ok(())
    }

    /// Reads the next row.
    pub fn row(&mut self, into: &mut RowReader) -> Result<Option<usize>, IoError> {
        if self.used == self.filled && !self.fill()? {
            return Ok(None);
        }
        let at = self.used;
        self.used += 1;
        self.row += 1;
        let batch = &self.batch;
        into.take(self.row, |k| match &batch[k] {
            Batch::Numbers(numbers) if numbers[at].is_nan() => Cell::Empty,
            Batch::Numbers(numbers) => Cell::Number(numbers[at]),
            Batch::Texts(texts) => match &texts[at] {
                Some(text) => Cell::Text(text.data()),
                None => Cell::Empty,
            },
        })?;
        Ok(Some((self.bytes / self.rows.max(1)).max(1) as usize))
    }

    fn open_group(&mut self) -> Result<bool, IoError> {
        if self.next_group >= self.reader.num_row_groups() {
            return Ok(false);
        }
        let open = || {
            let group = self.reader.get_row_group(self.next_group)?;
            let columns = (0..self.names.len()).map(|k| {
                let pages = Pages { inner: group.get_column_page_reader(k)?, known: false, late: None };
                Ok(get_column_reader(group.metadata().schema_descr().column(k), Box::new(pages)))
            });
            let columns = columns.collect::<Result<_, ParquetError>>()?;
            Ok((columns, usize::try_from(group.metadata().num_rows()).unwrap_or(0)))
        };
        (self.columns, self.left) = caught(open).map_err(|error| wrong(&self.file, &error))?;
        self.next_group += 1;
        Ok(true)
    }

    fn fill(&mut self) -> Result<bool, IoError> {
        while self.left == 0 {
            if !self.open_group()? {
                return Ok(false);
            }
        }
        let count = self.left.min(BATCH);
        for (k, (column, batch)) in self.columns.iter_mut().zip(&mut self.batch).enumerate() {
            let read = caught(|| read(column, batch, count, self.optional[k], self.unsigned[k]));
            if read.map_err(|error| wrong(&self.file, &error))? != count {
                let message =
                    format!("column `{}` ends before the others do", super::cells::shown(&self.names[k]));
                return Err(IoError::file(&self.file, message));
            }
        }
        self.left -= count;
        (self.filled, self.used) = (count, 0);
        Ok(true)
    }
}

/// What the library makes of bytes: it does not always end in an error where an altered file contradicts itself. What it leaves behind is not used again.
fn caught<T>(work: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, ParquetError> {
    catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|_| Err(ParquetError::General("its pages contradict themselves".into())))
}

fn wrong(file: &Path, error: &ParquetError) -> IoError {
    IoError::file(file, format!("cannot be read as Parquet: {error}"))
}

/// Reads so many rows of a column; how many there were.
fn read(
    column: &mut ColumnReader,
    batch: &mut Batch,
    count: usize,
    optional: bool,
    unsigned: bool,
) -> Result<usize, ParquetError> {
    match (column, batch) {
        (ColumnReader::DoubleColumnReader(column), Batch::Numbers(into)) => {
            rows(column, into, (count, optional), f64::NAN, |v| v)
        }
        (ColumnReader::FloatColumnReader(column), Batch::Numbers(into)) => {
            rows(column, into, (count, optional), f64::NAN, f64::from)
        }
        (ColumnReader::Int32ColumnReader(column), Batch::Numbers(into)) => {
            let number = |v: i32| if unsigned { f64::from(v.cast_unsigned()) } else { f64::from(v) };
            rows(column, into, (count, optional), f64::NAN, number)
        }
        (ColumnReader::Int64ColumnReader(column), Batch::Numbers(into)) => {
            let number = |v: i64| if unsigned { v.cast_unsigned() as f64 } else { v as f64 };
            rows(column, into, (count, optional), f64::NAN, number)
        }
        (ColumnReader::ByteArrayColumnReader(column), Batch::Texts(into)) => {
            rows(column, into, (count, optional), None, Some)
        }
        _ => Err(ParquetError::General("a column is of another type than the schema says".into())),
    }
}

fn rows<T: DataType, B: Clone>(
    column: &mut ColumnReaderImpl<T>,
    into: &mut Vec<B>,
    (count, optional): (usize, bool),
    empty: B,
    made: impl Fn(T::T) -> B,
) -> Result<usize, ParquetError> {
    into.clear();
    while into.len() < count {
        let (mut filled, mut values) = (Vec::new(), Vec::new());
        let levels = optional.then_some(&mut filled);
        let (records, ..) = column.read_records(count - into.len(), levels, None, &mut values)?;
        if records == 0 {
            break;
        }
        let mut values = values.into_iter();
        if optional {
            let cell = |level: &i16| if *level > 0 { values.next().map(&made) } else { Some(empty.clone()) };
            into.extend(filled.iter().filter_map(cell));
        } else {
            into.extend(values.map(&made));
        }
    }
    Ok(into.len())
}

fn skip(column: &mut ColumnReader, count: usize) -> Result<(), ParquetError> {
    match column {
        ColumnReader::DoubleColumnReader(column) => column.skip_records(count),
        ColumnReader::FloatColumnReader(column) => column.skip_records(count),
        ColumnReader::Int32ColumnReader(column) => column.skip_records(count),
        ColumnReader::Int64ColumnReader(column) => column.skip_records(count),
        ColumnReader::ByteArrayColumnReader(column) => column.skip_records(count),
        _ => Ok(0),
    }
    .map(|_| ())
}
