//! What is asked of a search, and its run: of all rows, or of all but one fold.

use crate::data::Data;
use crate::discover::Discovery;
use crate::error::input;
use crate::hypothesis::PythonHypothesis;
use crate::inputs::inputs;
use crate::model::{Model, of_python};
use crate::options::named_solver;
use crate::packed::{Packer, Unpacker};
use crate::robot::Robot;
use crate::run::{Raised, Working, on_threads, supervised};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};
use truepose_discover::{Diagnosis, DiscoverOptions, FoldRun, Library};
use truepose_errormodel::{Dataset, FittedModel};
use truepose_report::DiscoverySummary;
use truepose_workflow::{DiscoverRequest, Discovered, Interim, Observer, Search as Searching, SplitKind};

/// Robot, rows, declared model and options of a search.
#[pyclass(frozen, module = "truepose._core")]
pub struct Search {
    search: Arc<Searching>,
    raised: Raised,
    /// Objects of Python in the declared model.
    objects: Vec<Py<PyAny>>,
}

#[pymethods]
impl Search {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        robot: &Robot,
        data: &Data,
        model: Option<Vec<(String, Py<PyAny>)>>,
        solver_text: &str,
        holdout: Option<f64>,
        seed: u64,
        alpha: f64,
        rotations: usize,
        most: usize,
        hypotheses: Vec<Py<PyAny>>,
        without: Vec<String>,
        rivals: bool,
        nested: usize,
    ) -> PyResult<Self> {
        let Model { effects, objects, raised } = Model::of(py, model, &robot.chain)?;
        let mut library = Library::standard();
        for hypothesis in hypotheses {
            library = library.with(PythonHypothesis::new(hypothesis.bind(py), raised.clone())?);
        }
        for word in without {
            let Some(family) = library.family(&word) else {
                return Err(input(format!("without: no hypothesis has the family `{word}`")));
            };
            library = library.without(family);
        }
        let options = DiscoverOptions {
            holdout,
            seed,
            rotations,
            alpha,
            most,
            competing_fits: rivals,
            library,
            ..DiscoverOptions::default()
        };
        let nested = (nested > 0).then_some((nested, SplitKind::Random));
        let request = DiscoverRequest { options, nested, specification: None };
        let solver = named_solver(solver_text)?;
        let inputs = inputs(robot, data, effects);
        let search = supervised(py, None, vec![raised.clone()], move |working| {
            crate::model::prepare(&inputs.effects, &inputs.chain, &inputs.data)?;
            Searching::new(inputs, request, solver, working).map_err(input)
        })?;
        Ok(Search { search: Arc::new(search), raised, objects })
    }

    /// How many outer folds there are; 0 without nested cross-validation.
    #[getter]
    fn folds(&self) -> PyResult<usize> {
        self.search.folds().map_err(input)
    }

    /// The search of all rows, on so many threads, 0 for all; its nested cross-validation too, where `validated`.
    #[pyo3(signature = (validated, threads, progress))]
    fn run(
        &self,
        py: Python<'_>,
        validated: bool,
        threads: usize,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Discovery> {
        let search = self.search.clone();
        let kept = Arc::new(Mutex::new(None));
        let so_far = kept.clone();
        let work = move |working: &Working| {
            let shown = Keeping { working, so_far: &so_far };
            on_threads(threads, || {
                let mut made = search.run(&shown).map_err(input)?;
                if validated {
                    search.validate(&mut made, &shown).map_err(input)?;
                }
                Ok(made)
            })
        };
        match supervised(py, progress, vec![self.raised.clone()], work) {
            Ok(made) => Ok(self.finished(py, made)),
            Err(error) if error.is_instance_of::<PyKeyboardInterrupt>(py) => {
                let so_far = kept.lock().unwrap_or_else(PoisonError::into_inner).take();
                let found = so_far.map(|so_far| self.interrupted(py, so_far)).transpose()?;
                let interrupted = py.import("truepose")?.getattr("Interrupted")?;
                Err(PyErr::from_value(interrupted.call_method1("_of", (found,))?))
            }
            Err(error) => Err(error),
        }
    }

    /// The search without one of the outer folds, counted from 0, as bytes for `judged`; on so many threads, 0 for all.
    fn fold<'py>(&self, py: Python<'py>, fold: usize, threads: usize) -> PyResult<Bound<'py, PyBytes>> {
        let search = self.search.clone();
        let bytes = supervised(py, None, vec![self.raised.clone()], move |working: &Working| {
            let run = on_threads(threads, || search.without(fold, &|| working.go_on()).map_err(input))?;
            let mut out = Packer::default();
            out.bytes(&serde_json::to_vec(&run).map_err(input)?);
            Ok(out.finish())
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// What the search of all rows found, with the nested cross-validation that the runs of all folds come to.
    fn judged(&self, py: Python<'_>, found: &Discovery, folds: Vec<Vec<u8>>) -> PyResult<Discovery> {
        let read = |bytes: &Vec<u8>| serde_json::from_slice(Unpacker::new(bytes)?.bytes()?).map_err(input);
        let runs = folds.iter().map(read).collect::<PyResult<Vec<FoldRun>>>()?;
        let of = (&*found.found, &*found.data);
        let nested = py.detach(|| self.search.nested_of(of, runs)).map_err(input)?;
        Ok(found.validated(py, nested))
    }
}

/// Passes steps on, and keeps what is found so far for a run that is interrupted.
struct Keeping<'a> {
    working: &'a Working,
    so_far: &'a Mutex<Option<Interim>>,
}

impl Observer for Keeping<'_> {
    fn step(&self, words: &str) -> ControlFlow<()> {
        self.working.step(words)
    }

    fn interim(&self, so_far: Interim) -> ControlFlow<()> {
        *self.so_far.lock().unwrap_or_else(PoisonError::into_inner) = Some(so_far);
        self.working.go_on()
    }
}

/// The findings with their rows, figures and remarks.
type Found = (Diagnosis, Arc<Dataset>, DiscoverySummary, Vec<String>);

impl Search {
    fn discovery(&self, py: Python<'_>, used: FittedModel, of: Found) -> Discovery {
        let mut objects: Vec<Py<PyAny>> = self.objects.iter().map(|object| object.clone_ref(py)).collect();
        objects.extend(of_python(used.model().effects()).map(|effect| effect.object().clone_ref(py)));
        let (found, data, summary, remarks) = of;
        Discovery {
            found: Arc::new(found),
            data,
            labels: self.search.source.info.visit_labels.clone(),
            summary,
            used: Arc::new(used),
            remarks,
            objects,
            raised: self.raised.clone(),
        }
    }

    fn finished(&self, py: Python<'_>, made: Discovered) -> Discovery {
        let data = self.search.campaign_of(&made).data.clone();
        let Discovered { found, summary, fitted, remarks, .. } = made;
        self.discovery(py, fitted, (found, data, summary, remarks))
    }

    /// What a search had found when it was interrupted.
    fn interrupted(&self, py: Python<'_>, so_far: Interim) -> PyResult<Discovery> {
        const WHY: &str = "interrupted";
        let (fitted, summary) = (so_far.fitted(WHY).map_err(input)?, so_far.summary(WHY));
        let data = self.search.campaign.data.clone();
        Ok(self.discovery(py, fitted, (*so_far.found, data, summary, Vec::new())))
    }
}
