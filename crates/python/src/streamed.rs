//! A streamed identification from pass to pass, for blocks that are anywhere.

use crate::accumulate::{Accumulator, packed};
use crate::data::{Data, reading};
use crate::error::{input, of_io};
use crate::fit::{Fit, Source};
use crate::model::Model;
use crate::options::{prior, solver};
use crate::robot::Robot;
use crate::run::{Raised, supervised};
use crate::table::Table;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::{Arc, Mutex, PoisonError};
use truepose_errormodel::{Dataset, LANDMARK, SESSION};
use truepose_identify::{FitOptions, Pass, StreamedOptions, StreamedRun};
use truepose_io::MeasurementsReader;
use truepose_report::StreamedSummary;
use truepose_workflow::record_streamed;

/// Rows as the streaming reader has them: directions of approach are those that the table states.
#[pyfunction]
pub fn take_block(py: Python<'_>, robot: &Robot, table: &Table, positions_only: bool) -> PyResult<Data> {
    let options = reading(robot, true, None, Vec::new(), Vec::new())?;
    let (chain, table) = (robot.chain.clone(), table.table.clone());
    let (data, info, warnings) = py.detach(|| {
        let mut reader = MeasurementsReader::in_memory(table, &chain, &options).map_err(of_io)?;
        if [SESSION, LANDMARK].into_iter().any(|name| reader.schema().channel(name).is_some()) {
            return Err(input(
                "columns `session` and `landmark` need the whole table, and are not read in blocks",
            ));
        }
        let mut data = Dataset::default();
        reader.read_block(usize::MAX, &mut data).map_err(of_io)?;
        if positions_only {
            data.orientation.fill(None);
        }
        Ok::<_, PyErr>((data, reader.info(), Vec::new()))
    })?;
    Ok(Data::new(robot.chain.clone(), (data, info, warnings)))
}

/// What is known between two passes.
#[pyclass(frozen, module = "truepose._core")]
pub struct Streaming {
    run: Mutex<StreamedRun>,
    solver: String,
    objects: Vec<Py<PyAny>>,
    raised: Raised,
}

#[pymethods]
impl Streaming {
    /// Rows that a sample should have.
    #[staticmethod]
    fn wanted(py: Python<'_>, robot: &Robot, model: Option<Vec<(String, Py<PyAny>)>>) -> PyResult<usize> {
        let model = Model::of(py, model, &robot.chain)?;
        StreamedRun::wanted(&robot.chain, &model.effects).map_err(input)
    }

    /// Decides the structure on a sample.
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        robot: &Robot,
        sample: &Data,
        model: Option<Vec<(String, Py<PyAny>)>>,
        solver_text: &str,
        folds: usize,
        prior_strength: &Bound<'_, PyAny>,
        linear: bool,
    ) -> PyResult<Self> {
        let chain = robot.chain.clone();
        let Model { effects, objects, raised } = Model::of(py, model, &chain)?;
        let (made, text) = solver(solver_text)?;
        if folds == 1 {
            return Err(input("folds: one fold leaves no data to fit; use 2 or more, or 0 for none"));
        }
        let fit = FitOptions { refine: !linear, prior: prior(prior_strength)?, ..FitOptions::default() };
        let options = StreamedOptions { fit, folds };
        let rows = sample.data.clone();
        let run = supervised(py, None, vec![raised.clone()], move |_| {
            crate::model::prepare(&effects, &chain, &rows)?;
            StreamedRun::begin(&chain, &effects, (*rows).clone(), &*made, &options).map_err(input)
        })?;
        Ok(Streaming { run: Mutex::new(run), solver: text, objects, raised })
    }

    /// The next pass as bytes, and whether it is the last.
    #[pyo3(name = "pass_")]
    fn pass<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyBytes>, bool)> {
        let pass = self.run.lock().unwrap_or_else(PoisonError::into_inner).pass();
        let last = matches!(pass, Pass::Judge(_));
        Ok((PyBytes::new(py, &packed(&pass)?), last))
    }

    /// Takes the sums of a pass.
    fn solve(&self, py: Python<'_>, sums: &Accumulator) -> PyResult<()> {
        let sums = sums.sums()?;
        let (solver, _) = solver(&self.solver)?;
        py.detach(|| {
            let mut run = self.run.lock().unwrap_or_else(PoisonError::into_inner);
            run.solve(&sums, &*solver).map_err(input)
        })?;
        self.raised.take().map_or(Ok(()), Err)
    }

    /// Takes the residuals of the last pass.
    fn finish(&self, py: Python<'_>, residuals: &Accumulator) -> PyResult<Fit> {
        let judged = residuals.judged()?;
        let run = self.run.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let mut found = run.finish(&judged).map_err(input)?;
        let summary = StreamedSummary::new(&found, &self.solver);
        let converged = found.fit.converged;
        record_streamed(&mut found.fit.fitted, &summary, converged);
        Ok(Fit {
            fitted: Arc::new(found.fit.fitted),
            source: Source::Other(serde_json::to_string(&summary).map_err(input)?, summary.to_string()),
            objects: self.objects.iter().map(|object| object.clone_ref(py)).collect(),
            raised: self.raised.clone(),
            accepted: false,
        })
    }
}
