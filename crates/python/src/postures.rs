//! Postures as a Python effect sees them: a batch of rows with joint values, signals and loads.

use numpy::IntoPyArray;
use numpy::ndarray::Array2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The inputs of an effect in one row, in a fixed order: joint values, signals, then loads.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    /// Names of the moving joints.
    pub joints: Vec<String>,
    /// Names of the signals that the effect needs.
    pub signals: Vec<String>,
    /// Whether the loads about (along) the joints follow.
    pub loads: bool,
}

impl Layout {
    /// Numbers of a row.
    pub fn width(&self) -> usize {
        self.joints.len() * if self.loads { 2 } else { 1 } + self.signals.len()
    }

    /// Rows of numbers as keyword arguments of `truepose.Postures`.
    pub fn arrays<'py>(&self, py: Python<'py>, rows: &[f64]) -> PyResult<Bound<'py, PyDict>> {
        let width = self.width().max(1);
        let count = rows.len() / width;
        let dof = self.joints.len();
        let part = |from: usize, columns: usize| {
            Array2::from_shape_fn((count, columns), |(i, j)| rows[i * width + from + j]).into_pyarray(py)
        };
        let all = PyDict::new(py);
        all.set_item("joints", &self.joints)?;
        all.set_item("q", part(0, dof))?;
        let signals = PyDict::new(py);
        for (k, name) in self.signals.iter().enumerate() {
            let column: Vec<f64> = (0..count).map(|i| rows[i * width + dof + k]).collect();
            signals.set_item(name, crate::arrays::vector(py, column))?;
        }
        all.set_item("signals", signals)?;
        let loads = if self.loads { dof } else { 0 };
        all.set_item("loads", part(dof + self.signals.len(), loads))?;
        Ok(all)
    }
}
