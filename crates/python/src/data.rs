//! Measurements of a robot, read once.

use crate::arrays::{beside, rows, vector};
use crate::error::{input, of_io, warnings};
use crate::robot::Robot;
use crate::table::Table;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use truepose_errormodel::{Dataset, configurations};
use truepose_io::{
    ColumnMap, CsvInfo, MeasurementsOptions, OrientationConvention, Warning, measurements_in_memory,
    read_measurements,
};
use truepose_kinematics::{Chain, Load};
use truepose_workflow::Mistakes;

/// Rows of a robot in SI units, with what was understood of their table.
#[pyclass(frozen, module = "truepose._core")]
pub struct Data {
    pub data: Arc<Dataset>,
    pub info: Arc<CsvInfo>,
    pub chain: Arc<Chain>,
    warnings: Vec<String>,
}

impl Data {
    pub fn new(chain: Arc<Chain>, (data, info, said): (Dataset, CsvInfo, Vec<Warning>)) -> Self {
        Data { data: Arc::new(data), info: Arc::new(info), chain, warnings: warnings(&said) }
    }

    /// The same rows.
    fn shared(&self) -> Self {
        let (data, info, chain) = (self.data.clone(), self.info.clone(), self.chain.clone());
        Data { data, info, chain, warnings: self.warnings.clone() }
    }

    /// The name of the file, or `data`.
    pub fn name(&self) -> String {
        self.info.file.display().to_string()
    }

    /// Refuses several installations, and rows at landmarks, for a verb that takes measured poses of one.
    pub fn plain(&self) -> PyResult<()> {
        let words = match (self.info.sessions.len() < 2, self.info.landmarks.is_empty()) {
            (true, true) => return Ok(()),
            (false, _) => {
                format!("it holds {} sessions ({})", self.info.sessions.len(), self.info.sessions.join(", "))
            }
            (true, false) => "it has rows at landmarks".into(),
        };
        let words = format!("{}: {words}; this takes measured poses of one installation", self.name());
        Err(input(words))
    }

    /// Suspected mistakes, with the name of the file.
    pub fn suspected(&self) -> Vec<String> {
        Mistakes::of(&self.chain, &self.data, &self.info.file).words
    }
}

/// A column: name, unit, meaning, number of filled cells, range in the unit of the table.
type Seen = (String, String, String, usize, Option<(f64, f64)>);

/// How a table is read.
pub fn reading(
    robot: &Robot,
    measured: bool,
    orientation: Option<&str>,
    columns: Vec<(String, String)>,
    ignore: Vec<String>,
) -> PyResult<MeasurementsOptions> {
    let orientation = orientation
        .map(|word| {
            OrientationConvention::named(word).ok_or_else(|| {
                let known: Vec<&str> = OrientationConvention::WORDS.iter().map(|(word, _)| *word).collect();
                input(format!("unknown convention of orientations `{word}` (known: {})", known.join(", ")))
            })
        })
        .transpose()?;
    let own = ColumnMap { names: columns, ignore, orientation, ..ColumnMap::default() }.asked();
    Ok(MeasurementsOptions {
        measured_required: measured,
        columns: robot.columns.clone().with(&own),
        ..MeasurementsOptions::default()
    })
}

/// Reads a file: CSV, Parquet or Excel.
#[pyfunction]
#[pyo3(signature = (robot, path, measured=true, orientation=None, columns=Vec::new(), ignore=Vec::new(), positions_only=false))]
#[allow(clippy::too_many_arguments)]
pub fn read_data(
    py: Python<'_>,
    robot: &Robot,
    path: PathBuf,
    measured: bool,
    orientation: Option<&str>,
    columns: Vec<(String, String)>,
    ignore: Vec<String>,
    positions_only: bool,
) -> PyResult<Data> {
    let options = reading(robot, measured, orientation, columns, ignore)?;
    let chain = robot.chain.clone();
    let read = py.detach(|| read_measurements(Path::new(&path), &chain, &options)).map_err(of_io)?;
    Ok(Data::new(chain, positions(read, positions_only)))
}

/// Takes a table in memory.
#[pyfunction]
#[pyo3(signature = (robot, table, measured=true, orientation=None, columns=Vec::new(), ignore=Vec::new(), positions_only=false))]
#[allow(clippy::too_many_arguments)]
pub fn take_data(
    py: Python<'_>,
    robot: &Robot,
    table: &Table,
    measured: bool,
    orientation: Option<&str>,
    columns: Vec<(String, String)>,
    ignore: Vec<String>,
    positions_only: bool,
) -> PyResult<Data> {
    let options = reading(robot, measured, orientation, columns, ignore)?;
    let (chain, table) = (robot.chain.clone(), table.table.clone());
    let read = py.detach(|| measurements_in_memory(table, &chain, &options)).map_err(of_io)?;
    Ok(Data::new(chain, positions(read, positions_only)))
}

fn positions<I, W>((mut data, info, said): (Dataset, I, W), alone: bool) -> (Dataset, I, W) {
    if alone {
        data.orientation.fill(None);
    }
    (data, info, said)
}

#[pymethods]
impl Data {
    fn __len__(&self) -> usize {
        self.data.len()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.iter().cloned().chain(self.suspected()).collect()
    }

    /// Rows, pose measurements, configurations.
    #[getter]
    fn counts(&self) -> (usize, usize, usize) {
        (self.info.rows, self.info.visits, self.info.configurations)
    }

    /// Of each column: name, unit, meaning, number of filled cells, range in the unit of the table.
    #[getter]
    fn columns(&self) -> Vec<Seen> {
        let one = |c: &truepose_io::ColumnInfo| {
            (c.name.clone(), c.unit.clone(), c.meaning.clone(), c.filled, c.range)
        };
        self.info.columns.iter().map(one).collect()
    }

    /// Variables of the joints, rad or m, n × dof.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        beside(py, self.data.len(), &self.data.joints)
    }

    /// Measured positions, m, n × 3; NaN where none was measured.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, self.data.position.iter().copied())
    }

    /// Measured orientations, quaternions w x y z, n × 4; NaN where none was measured.
    #[getter]
    fn orientation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, self.data.orientation.iter().map(|q| q.unwrap_or([f64::NAN; 4])))
    }

    /// The pose measurement of each row, from 0.
    #[getter]
    fn visit<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        vector(py, self.data.visit.iter().map(|&v| v as i64).collect())
    }

    /// The configuration (joint values and load) of each row, from 0: groups for cross-validation.
    #[getter]
    fn configuration<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let of_visit = configurations(&self.data);
        vector(py, self.data.visit.iter().map(|&v| of_visit[v] as i64).collect())
    }

    /// Name of the target of each row; None is the tool's origin.
    #[getter]
    fn target(&self) -> Vec<Option<String>> {
        let name = |target: &Option<truepose_kinematics::TargetId>| {
            target.map(|target| self.chain.targets()[target.0].name.clone())
        };
        self.data.target.iter().map(name).collect()
    }

    /// Name of the session of each row; None of a table of one installation.
    #[getter]
    fn session(&self) -> Vec<Option<String>> {
        let several = self.info.sessions.len() > 1;
        let name = |row| self.info.sessions.get(self.data.session(row)).filter(|_| several).cloned();
        (0..self.data.len()).map(name).collect()
    }

    /// Name of the landmark of each row; None where a pose was measured.
    #[getter]
    fn landmark(&self) -> Vec<Option<String>> {
        let name = |row| self.data.landmark(row).and_then(|k| self.info.landmarks.get(k).cloned());
        (0..self.data.len()).map(name).collect()
    }

    /// Mass carried, kg; NaN where a wrench was measured.
    #[getter]
    fn payload<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let mass = |load: &Load| match load {
            Load::None => 0.0,
            Load::Payload(payload) => payload.mass,
            Load::Wrench(_) => f64::NAN,
        };
        vector(py, self.data.load.iter().map(mass).collect())
    }

    /// Channels by name, in their units of memory.
    #[getter]
    fn channels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (channel, values) in self.data.schema.channels.iter().zip(&self.data.channels) {
            all.set_item(&channel.name, vector(py, values.clone()))?;
        }
        Ok(all)
    }

    /// Whole pose measurements of a block as a block of their own: nothing is known of other rows.
    fn block(&self, rows: Vec<usize>) -> PyResult<Data> {
        if rows.len() == self.data.len() {
            return Ok(Data { warnings: Vec::new(), ..self.shared() });
        }
        let made = self.select(rows)?;
        let Data { data, info, chain, warnings } = made;
        let data = Dataset { record: None, ..Arc::unwrap_or_clone(data) };
        Ok(Data { data: Arc::new(data), info, chain, warnings })
    }

    /// The rows with these numbers (from 0), in this order of ascending rows; pose measurements and directions of approach stay as they were.
    fn select(&self, rows: Vec<usize>) -> PyResult<Data> {
        if let Some(&row) = rows.iter().find(|&&row| row >= self.data.len()) {
            return Err(input(format!("there is no row {row}; the data has {}", self.data.len())));
        }
        let data = self.data.select(&rows);
        let of_visit = configurations(&data);
        let info = CsvInfo {
            rows: data.len(),
            visits: data.visit.iter().max().map_or(0, |last| last + 1),
            configurations: of_visit.iter().max().map_or(0, |last| last + 1),
            visit_labels: Vec::new(),
            ids: Vec::new(),
            ..(*self.info).clone()
        };
        let chain = self.chain.clone();
        Ok(Data { data: Arc::new(data), info: Arc::new(info), chain, warnings: Vec::new() })
    }
}
