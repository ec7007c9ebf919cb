//! Writes a table of measurements as Parquet: `cargo run -p truepose-io --features parquet --example parquet_from_csv FROM.csv TO.parquet
//! [--leave-out COLUMN] [--as-times COLUMN]`.
//!
//! Columns keep their names; one whose cells are all numbers, or empty, becomes one of numbers, and any other one of texts. Three row groups, Snappy. The last two
//! arguments spoil the table: `tests/parquet/` was made so from `tests/spoiled/good.csv`.

#![allow(clippy::print_stderr, reason = "a program for developers")]

use parquet::basic::{Compression, ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::error::Error;
use std::sync::Arc;

const GROUPS: usize = 3;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [from, to, options @ ..] = arguments.as_slice() else {
        return Err("FROM.csv TO.parquet [--leave-out COLUMN] [--as-times COLUMN]".into());
    };
    let after = |key: &str| options.iter().skip_while(|o| *o != key).nth(1);
    let text = std::fs::read_to_string(from)?;
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().ok_or("no header")?.split(',').collect();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    if rows.iter().any(|row| row.len() != names.len()) {
        return Err("quoted cells, or rows of different lengths".into());
    }
    let kept: Vec<usize> =
        (0..names.len()).filter(|&k| Some(names[k]) != after("--leave-out").map(|c| &**c)).collect();
    let times = |k: usize| after("--as-times").is_some_and(|column| column == names[k]);
    let number = |cell: &str| cell.is_empty() || cell.parse::<f64>().is_ok();
    let numbers: Vec<bool> = (0..names.len()).map(|k| rows.iter().all(|row| number(row[k]))).collect();
    let described = kept.iter().map(|&k| {
        let (physical, converted) = match (times(k), numbers[k]) {
            (true, _) => (Physical::INT64, ConvertedType::TIMESTAMP_MICROS),
            (false, true) => (Physical::DOUBLE, ConvertedType::NONE),
            (false, false) => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
        };
        let column = Type::primitive_type_builder(names[k], physical).with_converted_type(converted);
        column.with_repetition(Repetition::OPTIONAL).build().map(Arc::new)
    });
    let fields = described.collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("measurements").with_fields(fields).build()?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer =
        SerializedFileWriter::new(std::fs::File::create(to)?, Arc::new(schema), Arc::new(properties))?;
    for part in rows.chunks(rows.len().div_ceil(GROUPS).max(1)) {
        let mut group = writer.next_row_group()?;
        for &k in &kept {
            let Some(mut column) = group.next_column()? else { break };
            let cells: Vec<&str> = part.iter().map(|row| row[k]).collect();
            let levels: Vec<i16> = cells.iter().map(|cell| i16::from(!cell.is_empty())).collect();
            let there = cells.iter().filter(|cell| !cell.is_empty());
            match (times(k), numbers[k]) {
                (true, _) => {
                    let values: Vec<i64> = there.map(|cell| cell.len() as i64).collect();
                    column.typed::<Int64Type>().write_batch(&values, Some(&levels), None)?
                }
                (false, true) => {
                    let values = there.map(|cell| cell.parse()).collect::<Result<Vec<f64>, _>>()?;
                    column.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?
                }
                (false, false) => {
                    let values: Vec<ByteArray> = there.map(|cell| ByteArray::from(*cell)).collect();
                    column.typed::<ByteArrayType>().write_batch(&values, Some(&levels), None)?
                }
            };
            column.close()?;
        }
        group.close()?;
    }
    writer.close()?;
    Ok(())
}
