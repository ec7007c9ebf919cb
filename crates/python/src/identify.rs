//! `identify`: fits the declared model.

use crate::data::Data;
use crate::error::input;
use crate::fit::{Fit, Source};
use crate::identified::Identified;
use crate::model::Model;
use crate::options::{groups, prior, solver, split};
use crate::robot::Robot;
use crate::run::supervised;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use std::sync::Arc;
use truepose_cli::front;
use truepose_identify::{FitOptions, IdentificationOptions, Step, identify as identified};
use truepose_report::IdentificationSummary;

#[pyfunction]
#[pyo3(signature = (robot, data, model, solver_text, folds, split_kind, repeat, seed, holdout, prior_strength, linear, reduce_once, rounds, fold_labels, progress))]
#[allow(clippy::too_many_arguments)]
pub fn identify(
    py: Python<'_>,
    robot: &Robot,
    data: &Data,
    model: Option<Vec<(String, Py<PyAny>)>>,
    solver_text: &str,
    folds: usize,
    split_kind: &str,
    repeat: usize,
    seed: u64,
    holdout: Option<f64>,
    prior_strength: &Bound<'_, PyAny>,
    linear: bool,
    reduce_once: bool,
    rounds: Option<usize>,
    fold_labels: Option<PyReadonlyArray1<'_, i64>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Fit> {
    data.plain()?;
    let chain = robot.chain.clone();
    let model = Model::of(py, model, &chain)?;
    let (solver, solver_text) = solver(solver_text)?;
    if repeat == 0 {
        return Err(input("repeat has to be 1 or more"));
    }
    let fit = FitOptions {
        refine: !linear,
        second_reduction: !reduce_once,
        max_iterations: rounds.unwrap_or(FitOptions::default().max_iterations),
        prior: prior(prior_strength)?,
        ..FitOptions::default()
    };
    let split = match &fold_labels {
        Some(labels) => Some(groups(&data.data, labels)?),
        None => split(&data.data, folds, split_kind, seed, holdout)?,
    };
    let options = IdentificationOptions { fit, split, repeats: repeat, holdout, seed };
    let (rows, details, info) = (data.data.clone(), robot.details.clone(), data.info.clone());
    let suspected = data.suspected();
    let raised = model.raised.clone();
    let Model { effects, objects, .. } = model;
    let made = supervised(py, progress, vec![raised.clone()], move |working| {
        crate::model::prepare(&effects, &chain, &rows)?;
        let observer = |step: Step| working.step(words(step));
        let mut found = identified(&chain, &effects, &rows, &*solver, &options, &observer).map_err(input)?;
        let held_out_by = options.split.as_ref().map(front::split_words);
        let mut summary =
            IdentificationSummary::new(&found, &rows, &info.visit_labels, &solver_text, held_out_by);
        summary.warnings.splice(0..0, suspected);
        front::record_details(&mut found.fit.fitted, &details);
        front::record_columns(&mut found.fit.fitted, &info.map);
        front::identified(&mut found.fit.fitted, &solver_text, rows.len(), seed, holdout.is_some());
        Ok(Identified { found, data: rows, labels: info.visit_labels.clone(), summary })
    })?;
    let fitted = Arc::new(made.found.fit.fitted.clone());
    Ok(Fit { fitted, source: Source::Identified(Box::new(made)), objects, raised })
}

fn words(step: Step) -> &'static str {
    match step {
        Step::Placing => "estimating base, tool and target frames",
        Step::FramesOnly => "fitting base and tool",
        Step::Fitting => "fitting the declared model",
        Step::Validating => "cross-validating",
        Step::Judging => "evaluating repeatability and observability",
    }
}
