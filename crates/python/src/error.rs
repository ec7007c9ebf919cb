//! Errors as exceptions: what is wrong with an input is `truepose.InputError`, with the row and the column where there are such.

use pyo3::PyTypeInfo;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use truepose_io::{IoError, Warning};

create_exception!(
    truepose,
    InputError,
    PyValueError,
    "An input that cannot be used.\n\n`row` counts from 1 (in a file: its line), `column` is the header; both are None where the error is about the \
     whole. `source` is the file, or `data`. `errors` are all that were found, each (row, column, message)."
);

/// Gives every such exception its attributes, whoever raises it.
pub fn complete(py: Python<'_>) -> PyResult<()> {
    let class = InputError::type_object(py);
    for attribute in ["row", "column", "source"] {
        class.setattr(attribute, py.None())?;
    }
    class.setattr("errors", PyTuple::empty(py))
}

/// Where something is wrong, and what.
type Place = (Option<u64>, Option<String>, String);

/// An input error about no particular row.
pub fn input(message: impl std::fmt::Display) -> PyErr {
    located(message.to_string(), None, vec![(None, None, message.to_string())])
}

/// An input error at a row (from 1) of a column.
pub fn at_row(row: u64, column: &str, message: impl std::fmt::Display) -> PyErr {
    let place = (Some(row), Some(column.to_owned()), message.to_string());
    located(format!("row {row}, {column}: {message}"), None, vec![place])
}

/// Of an error of a file or a table.
pub fn of_io(error: IoError) -> PyErr {
    let mut places = Vec::new();
    collect(&error, &mut places);
    let source = error.path().to_string_lossy().into_owned();
    located(error.to_string(), Some(source), places)
}

fn collect(error: &IoError, places: &mut Vec<Place>) {
    match error {
        IoError::Several { errors, .. } => errors.iter().for_each(|error| collect(error, places)),
        IoError::Cell { line, name, message, .. } => {
            places.push((Some(*line).filter(|&line| line > 0), Some(name.clone()), message.clone()));
        }
        other => places.push((other.line_number().filter(|&line| line > 0), None, other.to_string())),
    }
}

fn located(message: String, source: Option<String>, places: Vec<Place>) -> PyErr {
    Python::attach(|py| {
        let (row, column) = places.first().map_or((None, None), |(row, column, _)| (*row, column.clone()));
        let made = || -> PyResult<PyErr> {
            let value = InputError::type_object(py).call1((message.clone(),))?;
            value.setattr("row", row)?;
            value.setattr("column", column)?;
            value.setattr("source", source)?;
            value.setattr("errors", places)?;
            Ok(PyErr::from_value(value))
        };
        made().unwrap_or_else(|error| error)
    })
}

/// Warnings as texts.
pub fn warnings(list: &[Warning]) -> Vec<String> {
    list.iter().map(Warning::to_string).collect()
}
