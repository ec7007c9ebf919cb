//! What `discover` found, as values that JSON and text share.

mod adequacy;
mod advice;
mod candidates;
mod dependence;
pub(crate) mod effects;
mod gain;
mod joints;
mod meaning;
mod nested;
mod parts;
mod sentences;
pub(crate) mod text;
mod verdict;

pub use adequacy::{
    LackOfFitSummary, NoiseFloorSummary, NoiseReference, StatedScaleSummary, TooFewPoses, UnexplainedSummary,
    WithdrawnSummary,
};
pub use candidates::{RefusedSummary, UntestableSummary};
pub use dependence::DependenceSummary;
pub use effects::{AlternativeSummary, FindingSummary};
pub use gain::{ExtrapolationSummary, GainSummary};
pub use joints::JointRepeatabilitySummary;
pub use nested::NestedSummary;
pub use parts::TrainAndHoldout;

use crate::{Correction, DataCheck, PositionStatistics, SpecificationLines};
use serde::{Deserialize, Serialize};
use truepose_discover::{Diagnosis, HeldOut, Termination, Verdict};
use truepose_errormodel::Dataset;
use truepose_identify::{AsFound, FitOptions, IdentifyError, Residuals, uncorrected};

/// The report of a discovery: `discovery.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DiscoverySummary {
    /// The robot's name.
    pub robot: String,
    /// Rows of data.
    pub rows: usize,
    /// Pose measurements.
    pub visits: usize,
    /// Where the held-out errors come from: a test set that was drawn before anything was fitted, or nested folds.
    pub held_out: HeldOut,
    /// Rows (1-based) of the test set; empty where held-out errors are those of all rows.
    pub holdout_rows: Vec<usize>,
    /// Rows (1-based) that no fit uses, though they are not so far out that they are reported as outliers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub suspect_rows: Vec<usize>,
    /// Lines of the file of these rows; empty of data from no file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub suspect_lines: Vec<u64>,
    /// Expected 3-D RMS of one new row if the model were perfect, mm; none when it is unknown.
    pub noise_floor_mm: Option<f64>,
    /// The same with its source and interval.
    pub noise_floor: NoiseFloorSummary,
    /// What seems wrong with the data; it stands first.
    #[serde(default, skip_serializing_if = "DataCheck::is_empty")]
    pub data_check: DataCheck,
    /// Which components of the position were measured, where some were not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub partial_rows: Option<crate::PartialRows>,
    /// What the run assumed of the installation, in sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub assumed: Vec<String>,
    /// Whether the model is adequate.
    pub verdict: Verdict,
    /// Dependence of poses on those measured before; none with fewer than ten poses.
    #[serde(default)]
    pub dependence: Option<DependenceSummary>,
    /// Repeatability in joint space, where it is significant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_repeatability: Option<JointRepeatabilitySummary>,
    /// With the declared model.
    pub before: TrainAndHoldout,
    /// With all findings.
    pub after: TrainAndHoldout,
    /// By how much the findings reduce the error on the held-out test set; none without findings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<GainSummary>,
    /// Errors on the last part in time and on a left-out region of joint space.
    #[serde(default)]
    pub extrapolation: Vec<ExtrapolationSummary>,
    /// Effects in the order in which they were added.
    pub effects: Vec<FindingSummary>,
    /// Candidates that were tested and not added.
    pub refused: Vec<RefusedSummary>,
    /// Hypotheses that this data cannot test.
    pub not_testable: Vec<UntestableSummary>,
    /// Lack of fit against repeated pose measurements, before and after.
    pub lack_of_fit: LackOfFitSummary,
    /// The residual that no effect of the model explains.
    pub unexplained: UnexplainedSummary,
    /// Factors on stated standard deviations that exceed the scatter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stated_sd_scaled_by: Option<StatedScaleSummary>,
    /// Findings that were withdrawn, since the declared model predicts unseen data better.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub withdrawn: Option<WithdrawnSummary>,
    /// Pose measurements and identifiable parameters of the declared model, where the former are fewer than three
    /// times the latter: too few for a reliable search.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub too_few_poses: Option<TooFewPoses>,
    /// Why the search ended.
    pub stopped: Termination,
    /// Nested cross-validation of the whole search.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nested: Option<NestedSummary>,
    /// Errors before anything of the arm was fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub as_found: Option<AsFoundSummary>,
    /// Held-out poses against a specification, where one was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub specification: Option<SpecificationLines>,
    /// Each session of a campaign of several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sessions: Vec<crate::SessionSummary>,
    /// Spread at landmarks, where some were touched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub landmarks: Option<crate::LandmarksSummary>,
    /// Each kind of observation, where rows measured single numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kinds: Option<crate::KindsSummary>,
    /// What observed the robot, allowed not to be as described, against an error of the robot; where it was suspected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub observers: Option<crate::AllowedSummary>,
    /// The fitted robot in the numbers of its own description, where they were worked out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameters: Option<crate::ParametersSummary>,
    /// Why the search was ended early, where it was: there may be more effects, competing hypotheses were not
    /// evaluated, and coefficients are those of the training part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub incomplete: Option<String>,
    /// Settings of the search.
    pub settings: DiscoverySettings,
}

/// Position errors before anything of the arm was fitted, on all rows that the fit uses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AsFoundSummary {
    /// Of the robot as it is described; null where base, tool or targets are declared unknown.
    pub as_described: Option<PositionStatistics>,
    /// With the best base, tool and targets.
    pub installation: PositionStatistics,
}

impl From<AsFound> for AsFoundSummary {
    fn from(found: AsFound) -> Self {
        AsFoundSummary {
            as_described: found.nominal.map(Into::into),
            installation: found.installation.into(),
        }
    }
}

/// Settings of a search that its result depends on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DiscoverySettings {
    /// Seed of every random choice.
    pub seed: u64,
    /// Fraction of the configurations in the test set, where it was given.
    pub holdout: Option<f64>,
    /// Random rotations behind each family-wise p-value.
    pub rotations: usize,
    /// Family-wise significance level.
    pub alpha: f64,
}

impl DiscoverySummary {
    /// Summary of a diagnosis.
    pub fn new(found: &Diagnosis, settings: DiscoverySettings) -> Self {
        let intervals = found.intervals.as_ref();
        let (mut before, mut after) =
            (TrainAndHoldout::from(&found.before), TrainAndHoldout::from(&found.after));
        if let Some(intervals) = intervals {
            before = before.with_intervals(intervals.before, intervals.with_outliers[0]);
            after = after.with_intervals(intervals.after, intervals.with_outliers[1]);
        }
        DiscoverySummary {
            robot: found.fit.fitted.chain().name().into(),
            rows: found.rows,
            visits: found.visits,
            held_out: found.held_out,
            holdout_rows: match found.held_out {
                HeldOut::TestSet => found.holdout_rows.iter().map(|row| row + 1).collect(),
                _ => Vec::new(),
            },
            suspect_rows: found.suspects.iter().map(|row| row + 1).collect(),
            suspect_lines: found
                .suspects
                .iter()
                .filter_map(|&row| found.data.line.get(row).copied())
                .collect(),
            noise_floor_mm: found.noise_floor.rms.map(|rms| 1e3 * rms),
            noise_floor: NoiseFloorSummary::new(found),
            dependence: found.dependence.as_ref().map(DependenceSummary::new),
            joint_repeatability: found.joints.as_ref().map(JointRepeatabilitySummary::new),
            data_check: DataCheck::default(),
            partial_rows: crate::PartialRows::of(&found.data),
            verdict: found.verdict,
            before,
            after,
            gain: intervals.and_then(|i| GainSummary::new(i, found.held_out)),
            extrapolation: found
                .extrapolations
                .iter()
                .map(|part| ExtrapolationSummary::new(found, part))
                .collect(),
            effects: found.findings.iter().map(|one| FindingSummary::new(one, &found.data)).collect(),
            refused: found.refused.iter().map(RefusedSummary::new).collect(),
            not_testable: found.untestable.iter().map(|u| UntestableSummary::new(u, found)).collect(),
            lack_of_fit: LackOfFitSummary::new(found),
            unexplained: UnexplainedSummary::new(found),
            stated_sd_scaled_by: StatedScaleSummary::of(found),
            withdrawn: found.withdrawn.as_ref().map(WithdrawnSummary::new),
            too_few_poses: TooFewPoses::of(found),
            stopped: found.stopped,
            nested: None,
            incomplete: None,
            assumed: Vec::new(),
            as_found: None,
            specification: None,
            sessions: Vec::new(),
            landmarks: None,
            kinds: None,
            observers: None,
            parameters: None,
            settings,
        }
    }
}

impl DiscoverySummary {
    /// With what seems wrong with the data; numbers of rows are then those of all its rows.
    #[must_use]
    pub fn with_data_check(mut self, data_check: DataCheck) -> Self {
        let of_all =
            |rows: &mut Vec<usize>| rows.iter_mut().for_each(|row| *row = data_check.row_of_all(*row));
        of_all(&mut self.holdout_rows);
        of_all(&mut self.suspect_rows);
        for effect in &mut self.effects {
            of_all(&mut effect.rows);
            effect.poses.iter_mut().for_each(of_all);
        }
        DiscoverySummary { data_check, ..self }
    }

    /// The same, with the held-out poses of `data` (as it was read) compared with a limit of the 3-D position error, m; the verdict is of what
    /// will be done.
    ///
    /// # Errors
    /// When the robot as it is does not fit the data.
    pub fn with_specification(
        mut self,
        (limit, correction): (f64, Correction),
        found: &Diagnosis,
        data: &Dataset,
    ) -> Result<Self, IdentifyError> {
        let worst = |errors: &Residuals| {
            crate::poses::largest_error_and_uncertainty_by_pose(data, &found.holdout_rows, errors)
        };
        let effects = found.fit.fitted.model().effects();
        let rows = (&found.data, &*found.holdout_rows);
        let other = uncorrected(&found.placement, effects, rows, &FitOptions::default())?;
        let compensated = &found.after.holdout;
        let constants = other.constants.as_ref().unwrap_or(compensated);
        let cases = [&other.as_is, constants, compensated].map(worst);
        self.specification = Some(SpecificationLines::new(limit, correction, &cases, other.described));
        Ok(self)
    }
}
