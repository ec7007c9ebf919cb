//! Tables through the Arrow PyCapsule interface, in and out: any frame that has `__arrow_c_stream__` (polars, pyarrow, DuckDB, pandas …), without
//! depending on any.

use crate::arrays::Given1;
use crate::error::input;
use crate::texts::texts_of;
use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::types::{
    ArrowPrimitiveType, Float16Type, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type,
    UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{
    Array, ArrayRef, Float64Array, RecordBatch, RecordBatchIterator, RecordBatchReader, StringArray,
};
use arrow_schema::{DataType, Field, Schema};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use std::ffi::CStr;
use std::sync::Arc;
use truepose_io::MemoryColumn;

/// The name of such a capsule.
const STREAM: &CStr = c"arrow_array_stream";

/// All columns of a frame, copied.
pub fn columns(py: Python<'_>, frame: &Bound<'_, PyAny>) -> PyResult<Vec<(String, MemoryColumn)>> {
    let capsule = frame.call_method0("__arrow_c_stream__")?;
    let capsule = capsule
        .cast::<PyCapsule>()
        .map_err(|_| PyTypeError::new_err("`__arrow_c_stream__` gave no capsule"))?;
    let pointer = capsule.pointer_checked(Some(STREAM))?.cast::<FFI_ArrowArrayStream>();
    // SAFETY: a capsule of this name holds a pointer to an ArrowArrayStream that is valid as long as the capsule is (the interface's
    // promise); `from_raw` moves the stream out and leaves a released one behind, as the interface demands of consumers.
    #[allow(unsafe_code)]
    let stream = unsafe { FFI_ArrowArrayStream::from_raw(pointer.as_ptr()) };
    let reader = RecordBatchStreamReader::try_new(stream).map_err(input)?;
    let schema = reader.schema();
    // Producers may call back into Python: the lock is kept.
    let batches = reader.collect::<Result<Vec<RecordBatch>, _>>().map_err(input)?;
    py.detach(|| {
        let one = |(k, field): (usize, &Arc<Field>)| {
            let chunks: Vec<&ArrayRef> = batches.iter().map(|batch| batch.column(k)).collect();
            Ok((field.name().clone(), column(field, &chunks)?))
        };
        schema.fields().iter().enumerate().map(one).collect()
    })
}

fn column(field: &Field, chunks: &[&ArrayRef]) -> PyResult<MemoryColumn> {
    Ok(match field.data_type() {
        DataType::Float64 => numbers::<Float64Type>(chunks, |v| v),
        DataType::Float32 => numbers::<Float32Type>(chunks, f64::from),
        DataType::Float16 => numbers::<Float16Type>(chunks, f64::from),
        DataType::Int8 => numbers::<Int8Type>(chunks, f64::from),
        DataType::Int16 => numbers::<Int16Type>(chunks, f64::from),
        DataType::Int32 => numbers::<Int32Type>(chunks, f64::from),
        DataType::Int64 => numbers::<Int64Type>(chunks, |v| v as f64),
        DataType::UInt8 => numbers::<UInt8Type>(chunks, f64::from),
        DataType::UInt16 => numbers::<UInt16Type>(chunks, f64::from),
        DataType::UInt32 => numbers::<UInt32Type>(chunks, f64::from),
        DataType::UInt64 => numbers::<UInt64Type>(chunks, |v| v as f64),
        DataType::Null => MemoryColumn::Numbers(vec![f64::NAN; chunks.iter().map(|c| c.len()).sum()]),
        DataType::Utf8 => texts_of(chunks.iter().flat_map(|chunk| chunk.as_string::<i32>().iter())),
        DataType::LargeUtf8 => texts_of(chunks.iter().flat_map(|chunk| chunk.as_string::<i64>().iter())),
        DataType::Utf8View => texts_of(chunks.iter().flat_map(|chunk| chunk.as_string_view().iter())),
        DataType::Dictionary(_, values)
            if matches!(**values, DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View) =>
        {
            let mut all: Vec<Option<String>> = Vec::new();
            for chunk in chunks {
                let dictionary = chunk.as_any_dictionary();
                let MemoryColumn::Texts { words, rows } =
                    column(&Field::new("", (**values).clone(), true), &[dictionary.values()])?
                else {
                    continue;
                };
                let keys = if dictionary.values().is_empty() {
                    vec![0; chunk.len()]
                } else {
                    dictionary.normalized_keys()
                };
                all.extend(keys.iter().enumerate().map(|(row, &key)| {
                    let word = *rows.get(key).filter(|_| chunk.is_valid(row))?;
                    word.map(|word| words[word as usize].clone())
                }));
            }
            texts_of(all.into_iter())
        }
        other => {
            return Err(input(format!(
                "column `{}` is of the type {other}, and a table of measurements holds plain numbers and texts; write times as seconds, and \
                 directions as -1, 0 or 1",
                field.name()
            )));
        }
    })
}

/// Null: NaN.
fn numbers<T: ArrowPrimitiveType>(chunks: &[&ArrayRef], convert: impl Fn(T::Native) -> f64) -> MemoryColumn {
    let mut all = Vec::with_capacity(chunks.iter().map(|chunk| chunk.len()).sum());
    for chunk in chunks {
        let values = chunk.as_primitive::<T>();
        if values.null_count() == 0 {
            all.extend(values.values().iter().map(|&value| convert(value)));
        } else {
            all.extend(values.iter().map(|value| value.map_or(f64::NAN, &convert)));
        }
    }
    MemoryColumn::Numbers(all)
}

/// Columns (arrays of float64, or lists of texts and None) as a capsule for `__arrow_c_stream__`.
#[pyfunction]
pub fn arrow_stream<'py>(
    py: Python<'py>,
    columns: Vec<(String, Bound<'py, PyAny>)>,
) -> PyResult<Bound<'py, PyCapsule>> {
    let mut fields = Vec::new();
    let mut arrays: Vec<ArrayRef> = Vec::new();
    for (name, column) in columns {
        let array: ArrayRef = match column.extract::<Given1<'_, f64>>() {
            Ok(numbers) => Arc::new(Float64Array::from(numbers.as_array().to_vec())),
            Err(_) => Arc::new(StringArray::from(column.extract::<Vec<Option<String>>>()?)),
        };
        fields.push(Field::new(name, array.data_type().clone(), true));
        arrays.push(array);
    }
    let schema = Arc::new(Schema::new(fields));
    let batch = RecordBatch::try_new(schema.clone(), arrays).map_err(input)?;
    let reader = RecordBatchIterator::new([Ok(batch)], schema);
    PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(reader)), STREAM)
}
