//! A robot from few poses, with its sisters as prior.

use crate::error::WorkflowError;
use crate::verdict::{FLEET, of_fleet};
use std::path::Path;
use truepose_errormodel::{Dataset, ErrorModel, FittedModel};
use truepose_identify::{FitOptions, Folds, Split, fit, place};
use truepose_kinematics::Chain;
use truepose_report::SisterSummary;
use truepose_solvers::Solver;
use truepose_upkeep::sister;

/// Reasons against a prior of this file: it is no fleet's, or these rows are in it.
pub fn prior_remarks(file: &Path, prior: &FittedModel, data: &Dataset) -> Vec<String> {
    let mut all = Vec::new();
    if !of_fleet(prior) {
        let words = "is the fit of one robot, and no fleet's prior: its intervals are not the scatter from robot to robot";
        all.push(format!("{}: {words}", file.display()));
    }
    let known = &prior.domain.sample.rows().joints;
    let of = |row: usize| data.joints.iter().map(move |joint| joint[row].to_bits());
    let count = known.first().map_or(0, Vec::len);
    let seen: std::collections::BTreeSet<Vec<u64>> =
        (0..count).map(|k| known.iter().map(|joint| joint[k].to_bits()).collect()).collect();
    let rows = (0..data.len()).filter(|&row| seen.contains(&of(row).collect::<Vec<_>>())).count();
    if rows > 0 {
        all.push(format!(
            "{}: {rows} of these rows are in the data of this fit: held-out figures are not of unseen poses",
            file.display()
        ));
    }
    all
}

/// The robot with its sisters as prior ([`truepose_upkeep::fleet`]), or alone where they do not help.
///
/// # Errors
/// When the fleet is of another robot or model, or the rows are too few.
pub fn identify_sister(
    prior: &FittedModel,
    chain: &Chain,
    data: &Dataset,
    split: &Split,
    solver: &dyn Solver,
) -> Result<(FittedModel, SisterSummary), WorkflowError> {
    let folds = Folds::new(data, split)?;
    let plain = |rows: &Dataset| -> Option<FittedModel> {
        let placed = place(chain, rows).ok()?.chain;
        let model = ErrorModel::new(placed, prior.model().effects().to_vec()).ok()?;
        Some(fit(&model, rows, solver, &FitOptions::default()).ok()?.fitted)
    };
    let found = sister(prior, chain, data, &folds, &plain)?;
    let mut fitted = match (found.helps(), plain(data)) {
        (false, Some(alone)) => alone,
        _ => found.made.fitted.clone(),
    };
    // A robot of its own, whatever it was pulled towards.
    fitted.provenance.remove(FLEET);
    fitted.provenance.insert("prior_is_a_fleet".into(), found.helps().into());
    let summary = SisterSummary::new(&found, data);
    Ok((fitted, summary))
}
