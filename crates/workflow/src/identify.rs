//! The declared model is fitted, and its accuracy estimated on held-out data.

use crate::campaign::{Campaign, Inputs, Source};
use crate::error::WorkflowError;
use crate::folds::{FoldsRequest, split, split_words};
use crate::observer::Observer;
use crate::parameters;
use crate::provenance::origin;
use crate::solver::NamedSolver;
use crate::verdict::FitVerdict;
use std::path::Path;
use truepose_errormodel::{FittedModel, ModelError};
use truepose_identify::{
    FitOptions, Identification, IdentificationOptions, IdentifyError, Step, identify as identified,
};
use truepose_report::{Correction, IdentificationSummary, StreamedSummary};

/// Request of an identification.
#[derive(Debug, Clone)]
pub struct IdentifyRequest {
    /// Folds of the cross-validation.
    pub folds: FoldsRequest,
    /// Number of random splits.
    pub repeats: usize,
    /// Fraction of the configurations in a test set that is drawn first.
    pub holdout: Option<f64>,
    /// Seed of every random choice.
    pub seed: u64,
    /// Of the fits.
    pub fit: FitOptions,
    /// Limit of the 3-D position error, m, of the robot after this correction.
    pub specification: Option<(f64, Correction)>,
}

impl Default for IdentifyRequest {
    fn default() -> Self {
        IdentifyRequest {
            folds: FoldsRequest::default(),
            repeats: 1,
            holdout: None,
            seed: 0,
            fit: FitOptions::default(),
            specification: None,
        }
    }
}

impl IdentifyRequest {
    /// Checks what can be checked without data.
    ///
    /// # Errors
    /// When an option has a value that it cannot have.
    pub fn validate(&self) -> Result<(), WorkflowError> {
        if self.repeats == 0 {
            return Err(WorkflowError::option("repeat", "has to be 1 or more"));
        }
        Ok(())
    }
}

/// A fit of the declared model.
#[derive(Debug)]
pub struct Identified {
    /// The fit with everything that was tested.
    pub found: Identification,
    /// Robot, effects and rows.
    pub campaign: Campaign,
    /// What they were made from.
    pub source: Source,
    /// Its figures.
    pub summary: IdentificationSummary,
    /// The fit of the robot alone, as files have it and other verbs use it.
    pub fitted: FittedModel,
}

impl Identified {
    /// Computes the parameters of the robot as it is described, for the summary.
    pub fn compute_parameters(&mut self) {
        self.summary.parameters = Some(parameters::parameters(&self.fitted.clone().of_robot()));
    }

    /// Computes where base, tool and targets that were found are, for the summary.
    pub fn compute_places(&mut self) {
        let Some(placement) = self.summary.placement.as_mut() else { return };
        placement.places = match &self.summary.parameters {
            Some(parameters) => parameters.found(&placement.found),
            None => parameters::places(&self.fitted.clone().of_robot(), &placement.found),
        };
    }
}

/// Fits the declared model, and estimates its accuracy on held-out data.
///
/// # Errors
/// When the request, the rows or the model cannot be used, a fit fails, or the observer ends the run.
pub fn identify(
    inputs: Inputs,
    request: &IdentifyRequest,
    NamedSolver { name, solver }: &NamedSolver,
    observer: &dyn Observer,
) -> Result<Identified, WorkflowError> {
    request.validate()?;
    let solver = &**solver;
    let (split, fewer) = split(&inputs.data, &request.folds, request.seed, request.holdout)?;
    fewer.iter().for_each(|words| observer.remark(words));
    // Folds of a channel are of all rows.
    let all_rows = !matches!(request.folds, FoldsRequest::Count(..));
    let (campaign, source) = Campaign::new(inputs, (solver, &request.fit), all_rows)?;
    campaign.remarks.iter().for_each(|words| observer.remark(words));
    campaign.without_test_set(request.holdout)?;
    let fit = campaign.options(&request.fit);
    let IdentifyRequest { repeats, holdout, seed, .. } = *request;
    let options = IdentificationOptions { fit, split, repeats, holdout, seed };
    let Campaign { chain, effects, data, .. } = &campaign;
    let begin = |step| observer.step(words(step));
    let found = identified(chain, effects, data, solver, &options, &begin).map_err(|error| {
        // With the result they are at its head.
        source.check.suspected.iter().for_each(|words| observer.remark(words));
        about_rows(&source.info.file, error)
    })?;
    let held_out_by = options.split.as_ref().map(split_words);
    let summary = IdentificationSummary::new(&found, data, &source.info.visit_labels, name, held_out_by);
    let mut summary = summary.with_data_check(source.check.clone());
    summary.assumed.clone_from(&source.assumed);
    if let Some(specification) = request.specification {
        summary = summary.with_specification(specification, &found, data)?;
    }
    summary = campaign.identified(summary, &found)?;
    let mut fitted = campaign.used(&found.fit.fitted)?;
    source.record(&mut fitted);
    FitVerdict::identified(&summary).record(&mut fitted);
    origin(&mut fitted, "identify", name, summary.rows);
    fitted.provenance.insert("seed".into(), seed.into());
    fitted.provenance.insert("structure_frozen_then_all_rows".into(), holdout.is_some().into());
    Ok(Identified { found, campaign, source, summary, fitted })
}

/// An error with the file of the rows, where it is about them.
pub fn about_rows(file: &Path, error: IdentifyError) -> WorkflowError {
    match error {
        IdentifyError::NothingMeasured { .. }
        | IdentifyError::Placement { .. }
        | IdentifyError::Model(ModelError::MissingSignal { .. }) => WorkflowError::about(file, error),
        _ => error.into(),
    }
}

/// Records in a fit that it was made block by block, and what is to be known of it.
pub fn record_streamed(fitted: &mut FittedModel, summary: &StreamedSummary, converged: bool) {
    FitVerdict::converged(converged).record(fitted);
    origin(fitted, "identify", &summary.solver, summary.rows);
    fitted.provenance.insert("structure_from_rows".into(), summary.sampled.into());
}

/// A step in words.
fn words(step: Step) -> &'static str {
    match step {
        Step::Placing => "estimating base, tool and target frames",
        Step::FramesOnly => "fitting base and tool",
        Step::Fitting => "fitting the declared model",
        Step::Validating => "cross-validating",
        Step::Judging => "evaluating repeatability and observability",
    }
}
