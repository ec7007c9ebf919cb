//! What is asked of a search, and its run: of all rows, or of all but one fold.

use crate::data::Data;
use crate::discover::{Discovery, usable};
use crate::error::input;
use crate::hypothesis::PythonHypothesis;
use crate::identify::campaign;
use crate::model::{Model, of_python};
use crate::options::{solver, split};
use crate::packed::{Packer, Unpacker};
use crate::robot::Robot;
use crate::run::{Raised, Working, on_threads, supervised};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::{Arc, Mutex, PoisonError};
use truepose_cli::front::{self, Campaign, Fitting, Searched};
use truepose_discover::{
    Diagnosis, DiscoverOptions, FoldRun, Library, Nested, Progress, diagnose, nested, nested_fold,
};
use truepose_errormodel::{AnyEffect, Dataset, FittedModel, SessionRules, Surroundings};
use truepose_identify::{FitOptions, Folds, Split, as_found};
use truepose_io::{CsvInfo, RobotDetails};
use truepose_kinematics::Chain;
use truepose_report::{DataCheck, DiscoverySettings, DiscoverySummary, NestedSummary};
use truepose_solvers::Solver;

/// Robot, rows, declared model and options of a search.
#[pyclass(frozen, module = "truepose._core")]
pub struct Search {
    asked: Arc<Asked>,
    /// Objects of Python in the declared model.
    objects: Vec<Py<PyAny>>,
}

struct Asked {
    chain: Arc<Chain>,
    rows: Arc<Dataset>,
    info: Arc<CsvInfo>,
    assumed: Vec<String>,
    details: RobotDetails,
    said: (SessionRules, Surroundings),
    effects: Vec<Box<dyn AnyEffect>>,
    raised: Raised,
    solver: String,
    options: DiscoverOptions,
    settings: DiscoverySettings,
    /// What seems wrong with the rows; of measured poses of one installation.
    data_check: Option<DataCheck>,
    /// The outer folds of nested cross-validation; none without it.
    split: Option<Split>,
}

/// What is found so far, for a run that is interrupted.
type SoFar = Arc<Mutex<Option<Box<Diagnosis>>>>;

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
        let (chain, assumed) = robot.opened(&data.data)?;
        let Model { effects, objects, raised } = Model::of(py, model, &chain)?;
        let (_, solver) = solver(solver_text)?;
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
        let plain = data.info.sessions.len() < 2 && data.info.landmarks.is_empty();
        let checked = plain.then(|| py.detach(|| front::checked(&chain, &data.data, &data.info.file)));
        let (rows, mut data_check) = match checked {
            Some((kept, check)) => (kept.map_or_else(|| data.data.clone(), Arc::new), Some(check)),
            None => (data.data.clone(), None),
        };
        let mut chain = chain;
        if let Some(check) = data_check.as_mut().filter(|_| !robot.details.gravity) {
            crate::model::prepare(&effects, &chain, &rows)?;
            let built = self::solver(&solver)?.0;
            let fitting: Fitting<'_> = (&*built, &FitOptions::default());
            let found = py.detach(|| front::vertical((&chain, &effects), &rows, fitting)).map_err(input)?;
            if let Some((with_gravity, words)) = found {
                check.suspected.push(words);
                chain = Arc::new(with_gravity);
            }
        }
        let asked = Asked {
            chain,
            split: split(&rows, nested, "random", seed, None)?,
            rows,
            data_check,
            info: data.info.clone(),
            assumed,
            details: robot.details.clone(),
            said: (robot.beside.rules, (*robot.beside.surroundings).clone()),
            effects,
            raised,
            solver,
            options,
            settings: DiscoverySettings { seed, holdout, rotations, alpha },
        };
        Ok(Search { asked: Arc::new(asked), objects })
    }

    /// How many outer folds there are; 0 without nested cross-validation.
    #[getter]
    fn folds(&self) -> PyResult<usize> {
        let Asked { rows, split, .. } = &*self.asked;
        split.as_ref().map_or(Ok(0), |split| Ok(Folds::new(rows, split).map_err(input)?.count))
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
        let asked = self.asked.clone();
        let so_far = SoFar::default();
        let kept = so_far.clone();
        let finished = |found| self.finished(py, found);
        let work = move |working: &Working| on_threads(threads, || asked.found(working, &kept, validated));
        match supervised(py, progress, vec![self.asked.raised.clone()], work) {
            Ok(found) => Ok(finished(found)),
            Err(error) if error.is_instance_of::<PyKeyboardInterrupt>(py) => {
                let kept = so_far.lock().unwrap_or_else(PoisonError::into_inner).take();
                let found = kept.map(|found| finished(self.asked.interrupted(*found)));
                let interrupted = py.import("truepose")?.getattr("Interrupted")?;
                Err(PyErr::from_value(interrupted.call_method1("_of", (found,))?))
            }
            Err(error) => Err(error),
        }
    }

    /// The search without one of the outer folds, counted from 0, as bytes for `judged`; on so many threads, 0 for all.
    fn fold<'py>(&self, py: Python<'py>, fold: usize, threads: usize) -> PyResult<Bound<'py, PyBytes>> {
        let asked = self.asked.clone();
        let bytes = supervised(py, None, vec![asked.raised.clone()], move |working: &Working| {
            let run = on_threads(threads, || asked.without(fold, working))?;
            let mut out = Packer::default();
            out.bytes(&serde_json::to_vec(&run).map_err(input)?);
            Ok(out.finish())
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// What the search of all rows found, with the nested cross-validation that the runs of all folds come to.
    fn judged(&self, py: Python<'_>, found: &Discovery, folds: Vec<Vec<u8>>) -> PyResult<Discovery> {
        let Some(split) = &self.asked.split else {
            return Err(input("nested cross-validation was not asked for"));
        };
        let read = |bytes: &Vec<u8>| serde_json::from_slice(Unpacker::new(bytes)?.bytes()?).map_err(input);
        let runs = match found.found.runs_of(split, &found.data) {
            Some(known) => known,
            None => folds.iter().map(read).collect::<PyResult<Vec<FoldRun>>>()?,
        };
        let nested = py.detach(|| Nested::of(runs, &self.asked.options)).map_err(input)?;
        Ok(found.validated(py, NestedSummary::new(&nested, front::split_words(split))))
    }
}

/// A search that has ended: what it found, its summary, the fit as it is used, the rows and remarks.
type Found = (Diagnosis, DiscoverySummary, FittedModel, Arc<Dataset>, Vec<String>);

impl Search {
    fn finished(&self, py: Python<'_>, (found, summary, used, data, remarks): Found) -> Discovery {
        let mut objects: Vec<Py<PyAny>> = self.objects.iter().map(|object| object.clone_ref(py)).collect();
        objects.extend(of_python(used.model().effects()).map(|effect| effect.object().clone_ref(py)));
        let (labels, raised) = (self.asked.info.visit_labels.clone(), self.asked.raised.clone());
        Discovery {
            found: Arc::new(found),
            data,
            labels,
            summary,
            used: Arc::new(used),
            remarks,
            objects,
            raised,
        }
    }
}

impl Asked {
    fn campaign(&self, solver: &dyn Solver) -> PyResult<Option<Campaign>> {
        let Asked { chain, rows, info, said, effects, .. } = self;
        crate::model::prepare(effects, chain, rows)?;
        let fitting: Fitting<'_> = (solver, &FitOptions::default());
        campaign(said.clone(), (chain, effects, rows), info, fitting)
    }

    /// Those of a campaign in several installations or at landmarks, or as they were given.
    fn searched<'a>(&'a self, campaign: Option<&'a Campaign>) -> Searched<'a> {
        match campaign {
            Some(campaign) => (campaign.chain(), campaign.effects(), campaign.data()),
            None => (&self.chain, &self.effects, &self.rows),
        }
    }

    fn found(&self, working: &Working, kept: &SoFar, validated: bool) -> PyResult<Found> {
        let (solver, _) = solver(&self.solver)?;
        let campaign = self.campaign(&*solver)?;
        let observer = |step: Progress| match step {
            Progress::Interim(diagnosis) => {
                *kept.lock().unwrap_or_else(PoisonError::into_inner) = Some(diagnosis);
                working.go_on()
            }
            step => working.step(&front::progress_words(&step)),
        };
        let search = |(chain, effects, rows): Searched<'_>, fit: FitOptions| {
            let options = DiscoverOptions { fit, ..self.options.clone() };
            diagnose(chain, effects, rows, &*solver, &options, &observer).map_err(|error| error.to_string())
        };
        let (campaign, found, observers) = match campaign {
            Some(campaign) => {
                let decided = campaign.decided((&*solver, &self.options.fit), &search).map_err(input)?;
                (Some(decided.0), decided.1, decided.2)
            }
            None => (None, search(self.searched(None), self.options.fit.clone()).map_err(input)?, None),
        };
        let (chain, effects, rows) = self.searched(campaign.as_ref());
        let options = &self.options;
        let data_check = match &self.data_check {
            Some(check) => check.clone(),
            None => front::suspected(chain, rows, &self.info.file),
        };
        let mut summary = DiscoverySummary::new(&found, self.settings).with_data_check(data_check);
        let (mut used, remarks) = match &campaign {
            Some(campaign) => {
                campaign.discovered(&mut summary, &found, (&*solver, &options.fit)).map_err(input)?;
                (campaign.used(&found.fit.fitted).map_err(input)?, campaign.remarks().to_vec())
            }
            None => (usable(&found.fit.fitted), Vec::new()),
        };
        summary.observers = observers;
        summary.assumed.clone_from(&self.assumed);
        if let Some(split) = self.split.as_ref().filter(|_| validated) {
            let observer = |fold: usize, step: Progress| {
                working.step(&format!("fold {}: {}", fold + 1, front::progress_words(&step)))
            };
            let judged = match found.runs_of(split, rows) {
                Some(runs) => Nested::of(runs, options),
                None => nested(chain, effects, rows, split, &*solver, options, &observer),
            }
            .map_err(input)?;
            summary.nested = Some(NestedSummary::new(&judged, front::split_words(split)));
        }
        if let Ok(found) = as_found(&found.placement, &found.data, &FitOptions::default()) {
            summary.as_found = Some(found.into());
        }
        front::verdict_of_search(&mut used, &summary, found.fit.converged);
        self.record(&mut used, rows.len(), true);
        let rows = campaign.map_or_else(|| self.rows.clone(), |campaign| Arc::new(campaign.data().clone()));
        Ok((found, summary, used, rows, remarks))
    }

    fn without(&self, fold: usize, working: &Working) -> PyResult<FoldRun> {
        let Some(split) = &self.split else {
            return Err(input("nested cross-validation was not asked for"));
        };
        let (solver, _) = solver(&self.solver)?;
        let campaign = self.campaign(&*solver)?;
        let (chain, effects, rows) = self.searched(campaign.as_ref());
        let observer = |_: Progress| working.go_on();
        nested_fold(chain, effects, rows, (split, fold), &*solver, &self.options, &observer).map_err(input)
    }

    /// What a search had found when it was interrupted.
    fn interrupted(&self, found: Diagnosis) -> Found {
        let why = Some("interrupted".to_owned());
        let summary = DiscoverySummary::new(&found, self.settings)
            .with_data_check(self.data_check.clone().unwrap_or_default());
        let summary = DiscoverySummary { incomplete: why, ..summary };
        let mut used = usable(&found.fit.fitted);
        self.record(&mut used, self.rows.len(), false);
        used.provenance.insert("incomplete".into(), "interrupted".into());
        (found, summary, used, self.rows.clone(), Vec::new())
    }

    fn record(&self, used: &mut FittedModel, rows: usize, all_rows: bool) {
        front::record_details(used, &self.details);
        front::record_columns(used, &self.info.map);
        front::discovered(used, &self.solver, rows, self.settings.seed, all_rows);
    }
}
