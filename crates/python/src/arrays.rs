//! Arrays between numpy and the library.

use crate::error::input;
use numpy::ndarray::{Array1, Array2, Array3, Dimension, Ix1, Ix2};
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray, PyUntypedArrayMethods};
use pyo3::Borrowed;
use pyo3::prelude::*;
use std::ops::Deref;
use truepose_kinematics::nalgebra::DMatrix;
use truepose_kinematics::{Chain, Pose};

/// An array of numpy, to be read. It is copied where its numbers are not aligned, as in buffers that came over a network or in packed records:
/// `as_array` has no defined behaviour there.
pub struct Given<'py, T: Element, D: Dimension>(PyReadonlyArray<'py, T, D>);

/// One column of numbers.
pub type Given1<'py, T> = Given<'py, T, Ix1>;

/// A table of numbers.
pub type Given2<'py, T> = Given<'py, T, Ix2>;

impl<'a, 'py, T: Element + 'a, D: Dimension + 'a> FromPyObject<'a, 'py> for Given<'py, T, D> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Given<'py, T, D>> {
        let array: PyReadonlyArray<'py, T, D> = object.extract()?;
        if object.getattr("flags")?.getattr("aligned")?.is_truthy()? {
            return Ok(Given(array));
        }
        Ok(Given(object.call_method0("copy")?.extract()?))
    }
}

impl<'py, T: Element, D: Dimension> Deref for Given<'py, T, D> {
    type Target = PyReadonlyArray<'py, T, D>;

    fn deref(&self) -> &PyReadonlyArray<'py, T, D> {
        &self.0
    }
}

/// Joint values of rows as the controller has them, n × dof, as variables of the chain.
pub fn joints(chain: &Chain, q: &Given2<'_, f64>) -> PyResult<Vec<Vec<f64>>> {
    let wanted = chain.movable().len();
    let found = q.shape()[1];
    if found != wanted {
        return Err(input(format!("q has {found} columns; the robot has {wanted} moving joints")));
    }
    let mut rows: Vec<Vec<f64>> = q.as_array().outer_iter().map(|row| row.to_vec()).collect();
    if let Some((row, column)) =
        rows.iter().enumerate().find_map(|(k, row)| Some((k, row.iter().position(|v| !v.is_finite())?)))
    {
        let name = &chain.joint(chain.movable()[column]).name;
        return Err(crate::error::at_row(row as u64 + 1, name, "is not a finite number"));
    }
    rows.iter_mut().for_each(|row| chain.joints_from_controller(row));
    Ok(rows)
}

/// The same by columns, one a moving joint.
pub fn columns(chain: &Chain, q: &Given2<'_, f64>) -> PyResult<Vec<Vec<f64>>> {
    let rows = joints(chain, q)?;
    Ok((0..chain.movable().len()).map(|joint| rows.iter().map(|row| row[joint]).collect()).collect())
}

/// Homogeneous transforms, n × 4 × 4.
pub fn transforms<'py>(py: Python<'py>, poses: &[Pose]) -> Bound<'py, PyArray3<f64>> {
    let mut all = Array3::zeros((poses.len(), 4, 4));
    for (mut into, pose) in all.outer_iter_mut().zip(poses) {
        for i in 0..3 {
            for j in 0..3 {
                into[(i, j)] = pose.rotation[(i, j)];
            }
            into[(i, 3)] = pose.translation[i];
        }
        into[(3, 3)] = 1.0;
    }
    all.into_pyarray(py)
}

/// Rows of N numbers.
pub fn rows<'py, const N: usize>(
    py: Python<'py>,
    rows: impl ExactSizeIterator<Item = [f64; N]>,
) -> Bound<'py, PyArray2<f64>> {
    let mut all = Array2::zeros((rows.len(), N));
    for (mut into, row) in all.outer_iter_mut().zip(rows) {
        into.iter_mut().zip(row).for_each(|(into, value)| *into = value);
    }
    all.into_pyarray(py)
}

/// Columns beside each other, n × columns.
pub fn beside<'py>(py: Python<'py>, rows: usize, columns: &[Vec<f64>]) -> Bound<'py, PyArray2<f64>> {
    Array2::from_shape_fn((rows, columns.len()), |(i, j)| columns[j][i]).into_pyarray(py)
}

/// A matrix.
pub fn matrix<'py>(py: Python<'py>, of: &DMatrix<f64>) -> Bound<'py, PyArray2<f64>> {
    Array2::from_shape_fn(of.shape(), |place| of[place]).into_pyarray(py)
}

/// Matrices of one size.
pub fn matrices<'py>(py: Python<'py>, of: &[&DMatrix<f64>]) -> Bound<'py, PyArray3<f64>> {
    let (rows, columns) = of.first().map_or((0, 0), |first| first.shape());
    Array3::from_shape_fn((of.len(), rows, columns), |(k, i, j)| of[k][(i, j)]).into_pyarray(py)
}

/// A vector.
pub fn vector<'py, T: numpy::Element>(py: Python<'py>, of: Vec<T>) -> Bound<'py, PyArray1<T>> {
    Array1::from_vec(of).into_pyarray(py)
}
