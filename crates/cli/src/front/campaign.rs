//! Measurements of several installations, at landmarks, or of single numbers, ready for a fit.

use crate::failure::Failure;
use crate::verbs::{campaign, observers};
use truepose_discover::Diagnosis;
use truepose_errormodel::{AnyEffect, Dataset, FittedModel, SessionRules, Surroundings};
use truepose_identify::{FitOptions, Identification};
use truepose_io::CsvInfo;
use truepose_kinematics::Chain;
use truepose_report::{AllowedSummary, DiscoverySummary, IdentificationSummary};
use truepose_solvers::Solver;

/// Robot, effects and rows of a fit, as `identify` and `discover` make them of what they read. Of one installation with measured positions they
/// are those that were given.
#[derive(Debug)]
pub struct Campaign(campaign::Campaign);

/// The robot, effects and rows that are searched.
pub type Searched<'a> = (&'a Chain, &'a [Box<dyn AnyEffect>], &'a Dataset);

/// The solver of a fit and its options.
pub type Fitting<'a> = (&'a dyn Solver, &'a FitOptions);

impl Campaign {
    /// Of what was read, with what a robot file says of sessions and of landmarks.
    ///
    /// # Errors
    /// When sessions or landmarks cannot be placed, or landmarks are not declared as they were used.
    pub fn of(
        said: (SessionRules, Surroundings),
        chain: Chain,
        effects: Vec<Box<dyn AnyEffect>>,
        data: Dataset,
        info: &CsvInfo,
        fit: Fitting<'_>,
    ) -> Result<Self, String> {
        campaign::Campaign::of(said, &info.file, chain, effects, data, info, fit)
            .map(Campaign)
            .map_err(Failure::message)
    }

    /// The robot, placed in the frame of the first installation.
    pub fn chain(&self) -> &Chain {
        &self.0.chain
    }

    /// The declared effects, and those of sessions, landmarks and sensors.
    pub fn effects(&self) -> &[Box<dyn AnyEffect>] {
        &self.0.effects
    }

    /// The rows.
    pub fn data(&self) -> &Dataset {
        &self.0.data
    }

    /// What its rows are to be fitted with.
    pub fn options(&self, options: &FitOptions) -> FitOptions {
        self.0.options(options)
    }

    /// What a user should know.
    pub fn remarks(&self) -> &[String] {
        &self.0.remarks
    }

    /// Searches robot, effects and rows with the options of their fits, and with what is suspected of landmarks and sensors allowed for as well,
    /// where something is: the better of both, as `discover` does.
    ///
    /// # Errors
    /// When a search fails, or is ended.
    pub fn decided(
        self,
        fit: Fitting<'_>,
        search: &dyn Fn(Searched<'_>, FitOptions) -> Result<Diagnosis, String>,
    ) -> Result<(Self, Diagnosis, Option<AllowedSummary>), String> {
        let of_one = |campaign: &campaign::Campaign| {
            let campaign::Campaign { chain, effects, data, .. } = campaign;
            search((chain, effects, data), campaign.options(fit.1)).map_err(Failure::Input)
        };
        let decided = observers::decided(self.0, fit, &of_one).map_err(Failure::message)?;
        let (campaign, found, told) = decided;
        Ok((Campaign(campaign), found, told))
    }

    /// Refuses a test set where landmarks are left out as a whole.
    ///
    /// # Errors
    /// Then.
    pub fn without_test_set(&self, holdout: Option<f64>) -> Result<(), String> {
        self.0.without_test_set(holdout).map_err(|failure| failure.message().replace("--holdout", "holdout"))
    }

    /// Adds to the summary of an identification what it says of sessions, landmarks and kinds of observation.
    ///
    /// # Errors
    /// When residuals cannot be computed.
    pub fn identified(
        &self,
        summary: IdentificationSummary,
        found: &Identification,
    ) -> Result<IdentificationSummary, String> {
        self.0.identified(summary, found).map_err(Failure::message)
    }

    /// Adds the same to the summary of a discovery.
    ///
    /// # Errors
    /// When residuals cannot be computed.
    pub fn discovered(
        &self,
        summary: &mut DiscoverySummary,
        found: &Diagnosis,
        of_fit: Fitting<'_>,
    ) -> Result<(), String> {
        self.0.discovered(summary, found, of_fit).map_err(Failure::message)
    }

    /// The fit of the robot alone, which knows its sessions: what is written to a file.
    ///
    /// # Errors
    /// When landmarks cannot be taken out.
    pub fn used(&self, fitted: &FittedModel) -> Result<FittedModel, String> {
        self.0.used(fitted).map_err(Failure::message)
    }
}
