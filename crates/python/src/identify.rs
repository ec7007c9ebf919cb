//! `identify`: fits the declared model.

use crate::arrays::Given1;
use crate::data::Data;
use crate::error::input;
use crate::fit::{Fit, Source};
use crate::inputs::inputs;
use crate::model::Model;
use crate::options::{groups, named_solver, prior};
use crate::robot::Robot;
use crate::run::supervised;
use pyo3::prelude::*;
use std::sync::Arc;
use truepose_identify::FitOptions;
use truepose_workflow::{FoldsRequest, IdentifyRequest, SplitKind, identify as identified};

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
    fold_labels: Option<Given1<'_, i64>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(Fit, Vec<String>)> {
    let model = Model::of(py, model, &robot.chain)?;
    let solver = named_solver(solver_text)?;
    let request = IdentifyRequest {
        folds: match &fold_labels {
            Some(labels) => FoldsRequest::Given(groups(&data.data, labels)?),
            None => FoldsRequest::Count(folds, SplitKind::named(split_kind).map_err(input)?),
        },
        repeats: repeat,
        holdout,
        seed,
        fit: FitOptions {
            refine: !linear,
            second_reduction: !reduce_once,
            max_iterations: rounds.unwrap_or(FitOptions::default().max_iterations),
            prior: prior(prior_strength)?,
            ..FitOptions::default()
        },
        specification: None,
    };
    let Model { effects, objects, raised } = model;
    let inputs = inputs(robot, data, effects);
    let made = supervised(py, progress, vec![raised.clone()], move |working| {
        crate::model::prepare(&inputs.effects, &inputs.chain, &inputs.data)?;
        identified(inputs, &request, &solver, working).map_err(input)
    })?;
    let (fitted, remarks) = (Arc::new(made.fitted.clone()), made.campaign.remarks.clone());
    let source = Source::Identified(Box::new(made));
    Ok((Fit { fitted, source, objects, raised, accepted: false }, remarks))
}
