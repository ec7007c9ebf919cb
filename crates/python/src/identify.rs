//! `identify`: fits the declared model.

use crate::arrays::Given1;
use crate::data::Data;
use crate::error::input;
use crate::fit::{Fit, Source};
use crate::identified::Identified;
use crate::model::Model;
use crate::options::{groups, prior, solver, split};
use crate::robot::Robot;
use crate::run::supervised;
use pyo3::prelude::*;
use std::sync::Arc;
use truepose_cli::front::{self, Campaign, Fitting};
use truepose_errormodel::{AnyEffect, Dataset, SessionRules, Surroundings};
use truepose_identify::{FitOptions, IdentificationOptions, Step, identify as identified};
use truepose_io::CsvInfo;
use truepose_kinematics::Chain;
use truepose_report::IdentificationSummary;

/// Rows of several installations, or at landmarks, made ready; none where they are measured poses of one.
pub fn campaign(
    said: (SessionRules, Surroundings),
    (chain, effects, rows): (&Chain, &[Box<dyn AnyEffect>], &Dataset),
    info: &CsvInfo,
    fitting: Fitting<'_>,
) -> PyResult<Option<Campaign>> {
    if info.sessions.len() < 2 && info.landmarks.is_empty() {
        return Ok(None);
    }
    Campaign::of(said, chain.clone(), effects.to_vec(), rows.clone(), info, fitting).map(Some).map_err(input)
}

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
    let (chain, assumed) = robot.opened(&data.data)?;
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
    let own_folds = fold_labels.is_some();
    let raised = model.raised.clone();
    let Model { effects, objects, .. } = model;
    let said = (robot.beside.rules, (*robot.beside.surroundings).clone());
    let (made, used, remarks) = supervised(py, progress, vec![raised.clone()], move |working| {
        crate::model::prepare(&effects, &chain, &rows)?;
        let fitting: Fitting<'_> = (&*solver, &options.fit);
        let campaign = campaign(said, (&chain, &effects, &rows), &info, fitting)?;
        let fit =
            campaign.as_ref().map_or_else(|| options.fit.clone(), |campaign| campaign.options(&options.fit));
        let options = IdentificationOptions { fit, ..options };
        let (chain, effects, data) = match &campaign {
            Some(campaign) => (campaign.chain(), campaign.effects(), campaign.data()),
            None => (&*chain, &effects[..], &*rows),
        };
        // Folds that are given are of all rows.
        let (kept, mut data_check) = match campaign.is_some() || own_folds {
            true => (None, front::suspected(chain, data, &info.file)),
            false => front::checked(chain, data, &info.file),
        };
        let data = kept.as_ref().unwrap_or(data);
        let vertical = match campaign.is_none() && !details.gravity {
            true => front::vertical((chain, effects), data, (&*solver, &options.fit)).map_err(input)?,
            false => None,
        };
        data_check.suspected.extend(vertical.iter().map(|(_, words)| words.clone()));
        let chain = vertical.as_ref().map_or(chain, |(chain, _)| chain);
        campaign.iter().try_for_each(|campaign| campaign.without_test_set(options.holdout)).map_err(input)?;
        let observer = |step: Step| working.step(words(step));
        let found = identified(chain, effects, data, &*solver, &options, &observer).map_err(input)?;
        let held_out_by = options.split.as_ref().map(front::split_words);
        let mut summary =
            IdentificationSummary::new(&found, data, &info.visit_labels, &solver_text, held_out_by);
        summary = summary.with_data_check(data_check);
        summary.assumed = assumed;
        let (mut used, remarks) = match &campaign {
            Some(campaign) => {
                summary = campaign.identified(summary, &found).map_err(input)?;
                (campaign.used(&found.fit.fitted).map_err(input)?, campaign.remarks().to_vec())
            }
            None => (found.fit.fitted.clone(), Vec::new()),
        };
        front::record_details(&mut used, &details);
        front::record_columns(&mut used, &info.map);
        front::identified(&mut used, &summary, seed, holdout.is_some());
        let labels = info.visit_labels.clone();
        let data =
            campaign.map(|campaign| Arc::new(campaign.data().clone())).or(kept.map(Arc::new)).unwrap_or(rows);
        Ok((Identified { found, data, labels, summary }, used, remarks))
    })?;
    let source = Source::Identified(Box::new(made));
    Ok((Fit { fitted: Arc::new(used), source, objects, raised, accepted: false }, remarks))
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
