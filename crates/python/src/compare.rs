//! `compare`: solver strategies on the same folds.

use crate::data::Data;
use crate::error::input;
use crate::inputs::inputs;
use crate::model::Model;
use crate::options::{prior, solver, split};
use crate::robot::Robot;
use crate::run::supervised;
use pyo3::prelude::*;
use truepose_errormodel::ErrorModel;
use truepose_identify::{FitOptions, Folds, compare as compared, place};
use truepose_report::ComparisonSummary;
use truepose_solvers::{PivotedQr, Solver};
use truepose_workflow::{Campaign, Observer, split_words};

/// The summary as JSON and as text.
#[pyfunction]
#[pyo3(signature = (robot, data, model, solvers, folds, split_kind, seed, prior_strength, progress))]
#[allow(clippy::too_many_arguments)]
pub fn compare(
    py: Python<'_>,
    robot: &Robot,
    data: &Data,
    model: Option<Vec<(String, Py<PyAny>)>>,
    solvers: Vec<String>,
    folds: usize,
    split_kind: &str,
    seed: u64,
    prior_strength: &Bound<'_, PyAny>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(String, String)> {
    let model = Model::of(py, model, &robot.chain)?;
    let raised = model.raised.clone();
    let made = solvers.iter().map(|text| solver(text)).collect::<PyResult<Vec<_>>>()?;
    let solvers: Vec<(String, Box<dyn Solver>)> = made.into_iter().map(|(made, text)| (text, made)).collect();
    let Some(split) = split(&data.data, folds, split_kind, seed)? else {
        return Err(input("a comparison needs at least 2 folds, and 2 configurations"));
    };
    let options = FitOptions { prior: prior(prior_strength)?, ..FitOptions::default() };
    let inputs = inputs(robot, data, model.effects);
    supervised(py, progress, vec![raised], move |working| {
        crate::model::prepare(&inputs.effects, &inputs.chain, &inputs.data)?;
        let plain = PivotedQr::default();
        let (Campaign { chain, effects, data: rows, .. }, _) =
            Campaign::new(inputs, (&plain, &options), true).map_err(input)?;
        let (chain, rows) = (&chain, &*rows);
        let placed = place(chain, rows).map_err(input)?.chain;
        let model = ErrorModel::new(placed, effects).map_err(input)?;
        let folds = Folds::new(rows, &split).map_err(input)?;
        let list = compared(&model, rows, &solvers, &options, &folds, &|name| {
            let _ = working.step(name);
        });
        let summary = ComparisonSummary::new(model.chain().name(), split_words(&split), &list);
        Ok((serde_json::to_string(&summary).map_err(input)?, summary.to_string()))
    })
}
