//! What to touch and to look at next.

use crate::verbs::plan_observed::{From, found_before, planned, target};
use truepose_errormodel::{Dataset, FittedModel, Surroundings};
use truepose_identify::PlanOptions;
use truepose_io::PlannedVisit;
use truepose_report::ObservedPlanSummary;

/// Which landmarks to touch from where, what a camera should look at: as `truepose plan --observe`, with postures within reach in which the target
/// of this name observes, or the first one.
///
/// # Errors
/// When there is no such target, or nothing can be planned with these surroundings.
pub fn plan_observed(
    fitted: &FittedModel,
    surroundings: &Surroundings,
    target_name: Option<&str>,
    goals: Option<&Dataset>,
    options: &PlanOptions,
) -> Result<(Vec<PlannedVisit>, ObservedPlanSummary), String> {
    let mut surroundings = surroundings.clone();
    found_before(&mut surroundings, fitted);
    let target =
        target(target_name, fitted).map_err(|failure| failure.message().replace("--target", "target"))?;
    planned(fitted, &surroundings, From::Reach(target), goals, options).map_err(|error| error.to_string())
}
