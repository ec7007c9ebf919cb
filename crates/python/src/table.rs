//! Tables of Python as tables of the reader: columns are copied once, so that nobody can change them while they are read without the
//! interpreter's lock.

use crate::arrays::Given1;
use crate::arrow;
use crate::error::{input, of_io};
use crate::texts::texts_of;
use pyo3::prelude::*;
use truepose_io::{MemoryColumn, MemoryTable};

/// A table in memory, made once of a frame.
#[pyclass(frozen, module = "truepose._core")]
pub struct Table {
    pub table: MemoryTable,
}

#[pymethods]
impl Table {
    /// Of columns with their headers: arrays of float64, or lists of texts and None.
    #[new]
    fn new(name: &str, columns: Vec<(String, Bound<'_, PyAny>)>) -> PyResult<Self> {
        let columns = columns
            .into_iter()
            .map(|(header, column)| {
                let column = of_python(&header, &column)?;
                Ok((header, column))
            })
            .collect::<PyResult<Vec<_>>>()?;
        Ok(Table { table: MemoryTable::new(name, columns).map_err(of_io)? })
    }

    /// Number of rows.
    fn __len__(&self) -> usize {
        self.table.rows()
    }

    /// The headers.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.table.names().to_vec()
    }
}

/// A table out of an object with `__arrow_c_stream__`.
#[pyfunction]
pub fn read_table(py: Python<'_>, name: &str, frame: &Bound<'_, PyAny>) -> PyResult<Table> {
    let columns = arrow::columns(py, frame)?;
    Ok(Table { table: MemoryTable::new(name, columns).map_err(of_io)? })
}

fn of_python(header: &str, column: &Bound<'_, PyAny>) -> PyResult<MemoryColumn> {
    if let Ok(numbers) = column.extract::<Given1<'_, f64>>() {
        return Ok(MemoryColumn::Numbers(numbers.as_array().to_vec()));
    }
    let texts: Vec<Option<String>> = column.extract().map_err(|_| {
        input(format!("column `{header}` holds neither numbers nor texts, or is not one-dimensional"))
    })?;
    Ok(texts_of(texts.into_iter()))
}
