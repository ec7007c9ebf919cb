//! `discover`: finds what the declared model lacks.

use crate::data::Data;
use crate::error::input;
use crate::fit::{Fit, Source};
use crate::hypothesis::PythonHypothesis;
use crate::identify::campaign;
use crate::model::{Model, of_python};
use crate::options::{solver, split};
use crate::page;
use crate::robot::Robot;
use crate::run::{Raised, supervised};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use truepose_cli::front::{self, Fitting};
use truepose_discover::{Diagnosis, DiscoverOptions, Library, Progress, diagnose, nested as nested_folds};
use truepose_errormodel::{Dataset, FittedModel};
use truepose_identify::{FitOptions, as_found};
use truepose_report::{DiscoverySettings, DiscoverySummary, NestedSummary, discovery_report};

/// A discovery with its data.
#[pyclass(frozen, module = "truepose._core")]
pub struct Discovery {
    found: Diagnosis,
    data: Arc<Dataset>,
    labels: Vec<i64>,
    summary: DiscoverySummary,
    /// The enlarged fit as it is used: it knows its sessions, and landmarks are no part of it.
    used: Arc<FittedModel>,
    remarks: Vec<String>,
    objects: Vec<Py<PyAny>>,
    raised: Raised,
}

#[pymethods]
impl Discovery {
    /// `discovery.json`.
    fn summary(&self) -> PyResult<String> {
        serde_json::to_string(&self.summary).map_err(input)
    }

    fn text(&self) -> String {
        self.summary.to_string()
    }

    /// What a user should know of sessions and landmarks.
    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }

    /// The enlarged fit.
    fn fit(&self, py: Python<'_>) -> PyResult<Fit> {
        Ok(Fit {
            fitted: self.used.clone(),
            source: Source::Discovered(Box::new((self.found.fit.clone(), self.found.data.clone()))),
            objects: self.objects.iter().map(|object| object.clone_ref(py)).collect(),
            raised: self.raised.clone(),
        })
    }

    /// Fits of competing hypotheses: number of the finding (from 0), words, fit.
    fn rivals(&self, py: Python<'_>) -> Vec<(usize, String, Fit)> {
        let one = |rival: &truepose_discover::CompetingFit| {
            let fit = Fit {
                fitted: Arc::new(usable(&rival.fit.fitted)),
                source: Source::Discovered(Box::new((rival.fit.clone(), self.found.data.clone()))),
                objects: self.objects.iter().map(|object| object.clone_ref(py)).collect(),
                raised: self.raised.clone(),
            };
            (rival.finding, rival.candidate.words(), fit)
        };
        self.found.competitors.iter().map(one).collect()
    }

    /// Figures of the report: name and SVG.
    fn figures(&self) -> PyResult<Vec<(String, String)>> {
        Ok(self.report()?.figures)
    }

    /// Writes the report into a folder.
    fn write_report(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        let mut summary = self.summary.clone();
        summary.parameters = Some(front::parameters(&self.used));
        py.detach(|| {
            page::write(&folder, "discovery.json", &summary, |run| {
                discovery_report(&summary, &self.found, &self.data, &self.labels, run).map_err(input)
            })
        })
    }
}

impl Discovery {
    fn report(&self) -> PyResult<truepose_report::Report> {
        let run = page::record("discovery.json", &[]);
        discovery_report(&self.summary, &self.found, &self.data, &self.labels, &run).map_err(input)
    }
}

/// What is found so far, for a run that is interrupted.
type SoFar = Arc<Mutex<Option<Box<Diagnosis>>>>;

#[pyfunction]
#[pyo3(signature = (robot, data, model, solver_text, holdout, seed, alpha, rotations, most, hypotheses, without, rivals, nested, progress))]
#[allow(clippy::too_many_arguments)]
pub fn discover(
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
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Discovery> {
    let chain = robot.chain.clone();
    let model = Model::of(py, model, &chain)?;
    let (solver, solver_text) = solver(solver_text)?;
    let raised = model.raised.clone();
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
    let nested_split = match nested {
        0 => None,
        folds => split(&data.data, folds, "random", seed, None)?,
    };
    let settings = DiscoverySettings { seed, holdout, rotations, alpha };
    let so_far = SoFar::default();
    let kept = so_far.clone();
    let (rows, details, labels) = (data.data.clone(), robot.details.clone(), data.info.visit_labels.clone());
    let map = data.info.map.clone();
    let words_of_solver = solver_text.clone();
    let Model { effects, objects, .. } = model;
    let run = {
        let (rows, details, info) = (rows.clone(), details.clone(), data.info.clone());
        let said = (robot.beside.rules, (*robot.beside.surroundings).clone());
        move |working: &crate::run::Working| {
            crate::model::prepare(&effects, &chain, &rows)?;
            let fit = FitOptions::default();
            let fitting: Fitting<'_> = (&*solver, &fit);
            let campaign = campaign(said, (&chain, &effects, &rows), &info, fitting)?;
            let (chain, effects, rows) = match &campaign {
                Some(campaign) => (campaign.chain(), campaign.effects(), campaign.data()),
                None => (&*chain, &effects[..], &*rows),
            };
            let observer = |step: Progress| match step {
                Progress::Interim(diagnosis) => {
                    *kept.lock().unwrap_or_else(PoisonError::into_inner) = Some(diagnosis);
                    working.go_on()
                }
                step => working.step(&front::progress_words(&step)),
            };
            let found = diagnose(chain, effects, rows, &*solver, &options, &observer).map_err(input)?;
            let mut summary = DiscoverySummary::new(&found, settings);
            let (mut used, remarks) = match &campaign {
                Some(campaign) => {
                    campaign.discovered(&mut summary, &found, (&*solver, &options.fit)).map_err(input)?;
                    (campaign.used(&found.fit.fitted).map_err(input)?, campaign.remarks().to_vec())
                }
                None => (usable(&found.fit.fitted), Vec::new()),
            };
            if let Some(split) = &nested_split {
                let observer = |fold: usize, step: Progress| {
                    working.step(&format!("fold {}: {}", fold + 1, front::progress_words(&step)))
                };
                let judged = nested_folds(chain, effects, rows, split, &*solver, &options, &observer)
                    .map_err(input)?;
                summary.nested = Some(NestedSummary::new(&judged, front::split_words(split)));
            }
            if let Ok(found) = as_found(&found.placement, &found.data, &FitOptions::default()) {
                summary.as_found = Some(found.into());
            }
            front::record_details(&mut used, &details);
            front::record_columns(&mut used, &info.map);
            front::discovered(&mut used, &solver_text, rows.len(), seed, true);
            let rows = campaign.as_ref().map(|campaign| Arc::new(campaign.data().clone()));
            Ok((found, summary, used, rows, remarks))
        }
    };
    let finished = |found: Diagnosis, summary, used: FittedModel, data: Arc<Dataset>, remarks| {
        let mut objects: Vec<Py<PyAny>> = objects.iter().map(|object| object.clone_ref(py)).collect();
        objects.extend(of_python(used.model().effects()).map(|effect| effect.object().clone_ref(py)));
        let (labels, raised, used) = (labels.clone(), raised.clone(), Arc::new(used));
        Discovery { found, data, labels, summary, used, remarks, objects, raised }
    };
    match supervised(py, progress, vec![raised.clone()], run) {
        Ok((found, summary, used, data, remarks)) => {
            Ok(finished(found, summary, used, data.unwrap_or(rows), remarks))
        }
        Err(error) if error.is_instance_of::<PyKeyboardInterrupt>(py) => {
            let kept = so_far.lock().unwrap_or_else(PoisonError::into_inner).take();
            let interrupted = py.import("truepose")?.getattr("Interrupted")?;
            let found = match kept {
                Some(found) => {
                    let why = Some("interrupted".to_owned());
                    let summary =
                        DiscoverySummary { incomplete: why, ..DiscoverySummary::new(&found, settings) };
                    let mut used = usable(&found.fit.fitted);
                    front::record_details(&mut used, &details);
                    front::record_columns(&mut used, &map);
                    front::discovered(&mut used, &words_of_solver, rows.len(), seed, false);
                    used.provenance.insert("incomplete".into(), "interrupted".into());
                    Some(finished(*found, summary, used, rows, Vec::new()))
                }
                None => None,
            };
            Err(PyErr::from_value(interrupted.call_method1("_of", (found,))?))
        }
        Err(error) => Err(error),
    }
}

/// A fit for poses of which nothing tells where in the order of the record they stand; as it is where that cannot be said of it.
fn usable(fitted: &FittedModel) -> FittedModel {
    fitted.without_order().unwrap_or_else(|_| fitted.clone())
}
