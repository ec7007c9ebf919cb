//! Effects that the declared model lacks are searched, added, and the enlarged model is tested.

use crate::campaign::{Campaign, Inputs, Source, decided};
use crate::error::WorkflowError;
use crate::folds::{FoldsRequest, SplitKind, split, split_words};
use crate::interim::Interim;
use crate::observer::Observer;
use crate::parameters;
use crate::provenance::searched;
use crate::solver::NamedSolver;
use crate::verdict::FitVerdict;
use std::ops::ControlFlow;
use std::sync::Arc;
use truepose_discover::{
    Diagnosis, DiscoverError, DiscoverOptions, FoldRun, Nested, Progress, diagnose, nested, nested_fold,
};
use truepose_errormodel::{Dataset, FittedModel, ModelError};
use truepose_identify::{FitOptions, Folds, IdentifyError, Split, as_found};
use truepose_report::{Correction, DiscoverySettings, DiscoverySummary, NestedSummary};

/// Request of a search.
#[derive(Debug, Clone, Default)]
pub struct DiscoverRequest {
    /// Of the search, but for the options of the fits, which are those of its rows.
    pub options: DiscoverOptions,
    /// Outer folds of nested cross-validation; none without it.
    pub nested: Option<(usize, SplitKind)>,
    /// Limit of the 3-D position error, m, of the robot after this correction.
    pub specification: Option<(f64, Correction)>,
}

/// A search with its rows.
pub struct Search {
    /// Robot, effects and rows.
    pub campaign: Campaign,
    /// What they were made from.
    pub source: Arc<Source>,
    request: DiscoverRequest,
    solver: NamedSolver,
    split: Option<Split>,
}

/// What a search found.
#[derive(Debug)]
pub struct Discovered {
    /// The findings, with everything that was tested.
    pub found: Diagnosis,
    /// Robot, effects and rows in which they were found, where that is not the campaign of the search: something that observed is allowed for.
    pub allowing: Option<Campaign>,
    /// Its figures.
    pub summary: DiscoverySummary,
    /// The enlarged fit of the robot alone, as files have it and other verbs use it.
    pub fitted: FittedModel,
    /// What a user should know of the campaign.
    pub remarks: Vec<String>,
}

impl Discovered {
    /// Computes the parameters of the robot as it is described, for the summary.
    pub fn compute_parameters(&mut self) {
        self.summary.parameters = Some(parameters::parameters(&self.fitted.clone().of_robot()));
    }
}

impl Search {
    /// Prepares a search of these rows.
    ///
    /// # Errors
    /// When the rows cannot be used, or not divided into the outer folds.
    pub fn new(
        inputs: Inputs,
        request: DiscoverRequest,
        solver: NamedSolver,
        observer: &dyn Observer,
    ) -> Result<Self, WorkflowError> {
        let (campaign, source) = Campaign::new(inputs, (&*solver.solver, &request.options.fit), false)?;
        let channels = repeated(&campaign.data, &source);
        let all = campaign.remarks.iter().chain(&source.check.suspected).chain(&channels);
        all.for_each(|words| observer.remark(words));
        let split = match request.nested {
            Some((folds, kind)) => {
                let folds = FoldsRequest::Count(folds, kind);
                let (split, _) = split(&campaign.data, &folds, request.options.seed, None)?;
                let single = "a single configuration cannot be divided into folds";
                Some(split.ok_or_else(|| WorkflowError::option("nested", single))?)
            }
            None => None,
        };
        Ok(Search { campaign, source: Arc::new(source), request, solver, split })
    }

    /// Number of outer folds; 0 without nested cross-validation.
    ///
    /// # Errors
    /// When the rows cannot be divided so.
    pub fn folds(&self) -> Result<usize, WorkflowError> {
        self.split.as_ref().map_or(Ok(0), |split| Ok(Folds::new(&self.campaign.data, split)?.count))
    }

    fn options(&self, campaign: &Campaign) -> DiscoverOptions {
        let fit = campaign.options(&self.request.options.fit);
        DiscoverOptions { fit, ..self.request.options.clone() }
    }

    fn settings(&self) -> DiscoverySettings {
        let DiscoverOptions { seed, holdout, rotations, alpha, .. } = self.request.options;
        DiscoverySettings { seed, holdout, rotations, alpha }
    }

    /// Robot, effects and rows in which something was found.
    pub fn campaign_of<'s>(&'s self, found: &'s Discovered) -> &'s Campaign {
        found.allowing.as_ref().unwrap_or(&self.campaign)
    }

    /// Searches all rows, without nested cross-validation.
    ///
    /// # Errors
    /// When a fit fails, there are too few poses, or the observer ends the run.
    pub fn run(&self, observer: &dyn Observer) -> Result<Discovered, WorkflowError> {
        let solver = &*self.solver.solver;
        let search = |campaign: &Campaign| {
            let Campaign { chain, effects, data, .. } = campaign;
            let shown = |step: Progress| match step {
                Progress::Interim(found) => observer.interim(Interim {
                    found,
                    source: self.source.clone(),
                    settings: self.settings(),
                    solver: self.solver.name.clone(),
                    rows: self.campaign.data.len(),
                }),
                step => observer.step(&words(&step)),
            };
            diagnose(chain, effects, data, solver, &self.options(campaign), &shown)
                .map_err(|error| self.about(error))
        };
        let fitting = (solver, &self.request.options.fit);
        let decided = decided(&self.campaign, fitting, &search)?;
        let campaign = decided.allowing.as_ref().unwrap_or(&self.campaign);
        let more = decided.remark.iter().chain(decided.allowing.iter().flat_map(|of| &of.remarks));
        let more: Vec<String> =
            more.filter(|words| !self.campaign.remarks.contains(words)).cloned().collect();
        more.iter().for_each(|words| observer.remark(words));
        let remarks = [&self.campaign.remarks[..], &more].concat();
        let found = decided.found;
        let mut summary = DiscoverySummary::new(&found, self.settings());
        campaign.discovered(&mut summary, &found, (solver, &self.options(campaign).fit))?;
        let mut summary = summary.with_data_check(self.source.check.clone());
        summary.assumed.clone_from(&self.source.assumed);
        summary.observers = decided.summary;
        if let Ok(as_it_was) = as_found(&found.placement, &found.data, &FitOptions::default()) {
            summary.as_found = Some(as_it_was.into());
        }
        let mut fitted = campaign.used(&found.fit.fitted)?;
        FitVerdict::discovered(&summary, found.fit.converged).record(&mut fitted);
        self.source.record(&mut fitted);
        searched(&mut fitted, &self.solver.name, self.campaign.data.len(), self.request.options.seed, true);
        let mut made = Discovered { found, allowing: decided.allowing, summary, fitted, remarks };
        self.judge(&mut made)?;
        Ok(made)
    }

    /// Compares with the specification, and records the verdict in the fit.
    fn judge(&self, made: &mut Discovered) -> Result<(), WorkflowError> {
        if let Some(specification) = self.request.specification {
            let data = &made.allowing.as_ref().unwrap_or(&self.campaign).data;
            made.summary = made.summary.clone().with_specification(specification, &made.found, data)?;
        }
        FitVerdict::discovered(&made.summary, made.found.fit.converged).record(&mut made.fitted);
        Ok(())
    }

    /// Adds the nested cross-validation that was requested: the search is repeated with each outer fold left out.
    ///
    /// # Errors
    /// When a search fails, or the observer ends the run.
    pub fn validate(&self, made: &mut Discovered, observer: &dyn Observer) -> Result<(), WorkflowError> {
        let Some(split) = &self.split else { return Ok(()) };
        let campaign = self.campaign_of(made);
        let Campaign { chain, effects, data, .. } = campaign;
        let options = self.options(campaign);
        let folds = Folds::new(data, split)?.count;
        let judged = match made.found.runs_of(split, data) {
            Some(runs) => Nested::of(runs, &options)?,
            None => {
                let shown = |fold: usize, step: Progress| {
                    observer.step(&format!("fold {} of {folds}: {}", fold + 1, words(&step)))
                };
                nested(chain, effects, data, split, &*self.solver.solver, &options, &shown)?
            }
        };
        made.summary.nested = Some(NestedSummary::new(&judged, split_words(split)));
        self.judge(made)
    }

    /// The search without one outer fold, counted from 0.
    ///
    /// # Errors
    /// When nested cross-validation was not requested, there is no such fold, or the search fails.
    pub fn without(
        &self,
        fold: usize,
        go_on: &(dyn Fn() -> ControlFlow<()> + Sync),
    ) -> Result<FoldRun, WorkflowError> {
        let split = self.split.as_ref().ok_or_else(not_nested)?;
        let Campaign { chain, effects, data, .. } = &self.campaign;
        let options = self.options(&self.campaign);
        Ok(nested_fold(chain, effects, data, (split, fold), &*self.solver.solver, &options, &|_| go_on())?)
    }

    /// The nested cross-validation that the runs of all outer folds come to; those of the search itself where it made the same folds.
    ///
    /// # Errors
    /// When nested cross-validation was not requested, or the runs do not belong to it.
    pub fn nested_of(
        &self,
        (found, data): (&Diagnosis, &Dataset),
        runs: Vec<FoldRun>,
    ) -> Result<NestedSummary, WorkflowError> {
        let split = self.split.as_ref().ok_or_else(not_nested)?;
        let runs = found.runs_of(split, data).unwrap_or(runs);
        let judged = Nested::of(runs, &self.options(&self.campaign))?;
        Ok(NestedSummary::new(&judged, split_words(split)))
    }

    /// An error with the file of the rows, where it is about them.
    fn about(&self, error: DiscoverError) -> WorkflowError {
        match error {
            DiscoverError::TooFewPoses { .. }
            | DiscoverError::Identify(
                IdentifyError::NothingMeasured { .. }
                | IdentifyError::Placement { .. }
                | IdentifyError::Model(ModelError::MissingSignal { .. }),
            ) => WorkflowError::about(&self.source.info.file, error),
            _ => error.into(),
        }
    }
}

fn not_nested() -> WorkflowError {
    WorkflowError::option("nested", "nested cross-validation was not requested")
}

/// Channels that the search tests as one, in words.
fn repeated(data: &Dataset, source: &Source) -> Option<String> {
    let channels = &data.schema.channels;
    let pairs = data.repeated_channels().into_iter().enumerate().filter_map(|(k, first)| Some((k, first?)));
    let pairs: Vec<(usize, usize)> = pairs.collect();
    let &(k, first) = pairs.first()?;
    let (other, first) = (&channels[k].name, &channels[first].name);
    let more = match pairs.len() - 1 {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    Some(format!(
        "{}: channel `{other}` has the values of `{first}`{more}: equal channels are tested as one, under the first name",
        source.info.file.display()
    ))
}

/// A step in words.
fn words(step: &Progress) -> String {
    match step {
        Progress::Fitting => "fitting the declared model".into(),
        Progress::Screening(0) => "screening all candidates".into(),
        Progress::Screening(found) => format!("screening again with {found} added"),
        Progress::Found(words) => format!("added {words}; fitting"),
        Progress::Interim(_) => "storing the findings so far".into(),
        Progress::Checking => "checking on data that the search did not use".into(),
        Progress::Reconsidering => "testing earlier findings again".into(),
        Progress::Judging => "evaluating on the held-out test set".into(),
    }
}
