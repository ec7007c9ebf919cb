//! The result of a discovery.

use crate::accept::evidence::{Evidence, Refused};
use crate::conclude::errors::Errors;
use crate::conclude::extrapolation::Extrapolation;
use crate::conclude::floor::NoiseFloor;
use crate::conclude::fold_run::FoldRun;
use crate::conclude::held_out::HeldOutIntervals;
use crate::conclude::partition::HeldOut;
use crate::conclude::stated::StatedScale;
use crate::conclude::trace::point::Trace;
use crate::conclude::verdict::{Unexplained, Verdict};
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::problem::dependence::Dependence;
use crate::problem::joint_noise::JointRepeatability;
use crate::screen::untestable::Untestable;
use crate::termination::Termination;
use serde::{Deserialize, Serialize};
use truepose_errormodel::Dataset;
use truepose_identify::{Fit, Placement, Repeats};

/// The result of [`diagnose`](crate::diagnose()). Errors in m; fits in SI units.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// Rows of the data.
    pub rows: usize,
    /// Pose measurements of the data.
    pub visits: usize,
    /// Placement of base, tool and targets that are declared unknown.
    pub placement: Placement,
    /// Accepted effects, in the order in which they were added.
    pub findings: Vec<Finding>,
    /// Candidates that had the best score and failed a test, with the reason.
    pub refused: Vec<Refused>,
    /// Fits of competing hypotheses that are not distinguishable; empty unless
    /// [`DiscoverOptions::competing_fits`](crate::DiscoverOptions::competing_fits).
    pub competitors: Vec<CompetingFit>,
    /// Families and places that the data cannot test, with the fraction that the declared model does not
    /// absorb and the smallest detectable size.
    pub untestable: Vec<Untestable>,
    /// Residuals of the declared model.
    pub before: Errors,
    /// Residuals of the model with all findings.
    pub after: Errors,
    /// Findings that were withdrawn; `None` when they stand.
    pub withdrawn: Option<Withdrawn>,
    /// Repeatability limit: expected 3-D RMS of one new row under a perfect model, with its source.
    pub noise_floor: NoiseFloor,
    /// Dependence of poses on those measured before, with the model of the search; `None` with fewer than ten poses.
    pub dependence: Option<Dependence>,
    /// Repeatability in joint space; `None` where it is not significant.
    pub joints: Option<JointRepeatability>,
    /// Whether the model is adequate.
    pub verdict: Verdict,
    /// Pure error of repeated poses and lack of fit of the declared model.
    pub repeats_before: Option<Repeats>,
    /// The same with all findings.
    pub repeats_after: Option<Repeats>,
    /// The residual beyond the repeatability limit.
    pub unexplained: Unexplained,
    /// Intervals of the errors on the held-out test set; `None` of fewer than five configurations.
    pub intervals: Option<HeldOutIntervals>,
    /// Errors on the last part in time and at the ends of a joint's range, where the data is enough.
    pub extrapolations: Vec<Extrapolation>,
    /// Factors on stated standard deviations that exceed the scatter.
    pub stated_scale: StatedScale,
    /// Why the search ended.
    pub stopped: Termination,
    /// The fit of the enlarged model on all rows, structure frozen.
    pub fit: Fit,
    /// The fit of the declared model on the training part.
    pub declared: Fit,
    /// Rows (0-based) that no fit uses, though they are not so far out that they are reported as outliers.
    pub suspects: Vec<usize>,
    /// Where the held-out errors come from.
    pub held_out: HeldOut,
    /// The runs of its nested folds; empty where there were none.
    pub fold_runs: Vec<FoldRun>,
    /// Rows (0-based) with a held-out error: the test set, or all.
    pub holdout_rows: Vec<usize>,
    /// The data of the final fit: payloads corrected, outliers excluded.
    pub data: Dataset,
}

/// An accepted effect.
#[derive(Debug, Clone)]
pub struct Finding {
    /// Family, place and change of the model.
    pub candidate: Candidate,
    /// Family-wise p of the test that found it.
    pub p_value: f64,
    /// Probability of its family and place, given that the effect exists.
    pub name_probability: f64,
    /// Probability that the library has no name for it.
    pub unnamed_probability: f64,
    /// Its evidence in the linearised problem at the time of its acceptance; `None` for excluded rows, which are
    /// not selected by the search.
    pub evidence: Option<Evidence>,
    /// 3-D RMS on the held-out test set before and after it was added, m.
    pub holdout: (f64, f64),
    /// 3-D RMS on the training rows before and after it was added, m.
    pub train: (f64, f64),
    /// Its coefficients in the final fit.
    pub parameters: Vec<Parameter>,
    /// Its nonlinear parameters (file key `shape`): periods, change points, time constants, lags, dead-band
    /// loads. An interval as wide as the search range means that the parameter is not identifiable.
    pub shape: Vec<Parameter>,
    /// Competing hypotheses, in order of their difference of score.
    pub alternatives: Vec<Alternative>,
    /// Rows (0-based, of all data) that it concerns: outliers, or rows with the corrected payload; empty for
    /// effects on all rows.
    pub rows: Vec<usize>,
    /// Of outliers: the rows of each pose measurement that is displaced as a whole; they are among `rows`.
    pub poses: Vec<Vec<usize>>,
    /// Partial residuals against the driver of the effect; `None` for outliers.
    pub trace: Option<Trace>,
}

/// An estimate with its interval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Name of the coefficient or nonlinear parameter.
    pub name: String,
    /// Estimate, in `unit`.
    pub value: f64,
    /// SI unit.
    pub unit: String,
    /// 95 % confidence interval, in `unit`.
    pub ci95: [f64; 2],
}

/// A competing hypothesis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Alternative {
    /// Family.
    pub family: Family,
    /// Place.
    #[serde(flatten)]
    pub place: Place,
    /// 3-D RMS on the held-out test set with it in place of the finding, m.
    pub holdout: f64,
    /// Difference from the finding in −2 ln L + coefficient penalty; positive: less likely.
    pub behind: f64,
    /// Probability of this family and place, given that the effect exists.
    pub probability: f64,
    /// Whether it is not distinguishable from the finding with this data.
    pub equivalent: bool,
    /// Whether it is the simplest of these, and simpler than the finding.
    pub simplest: bool,
}

/// The fit of the model with a competing hypothesis in place of a finding from which it is not
/// distinguishable.
#[derive(Debug, Clone)]
pub struct CompetingFit {
    /// Index of the finding, from zero.
    pub finding: usize,
    /// The competing hypothesis.
    pub candidate: Candidate,
    /// Fitted to all rows, like the final model.
    pub fit: Fit,
}

/// Data on which the enlarged model predicts worse than the declared one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Check {
    /// Training rows, each predicted by a refit of the same structure without its fold.
    Refits,
    /// Training rows outside of the sample that was searched.
    UnsearchedRows,
    /// Training rows, each predicted by a run of the whole search without its fold.
    NestedFolds,
    /// The held-out test set.
    TestSet,
}

/// Findings that were withdrawn, because the declared model predicts unseen data better.
#[derive(Debug, Clone)]
pub struct Withdrawn {
    /// The check that failed.
    pub check: Check,
    /// 3-D RMS of the declared model on the rows of that check, m.
    pub declared: f64,
    /// The same with the findings, m.
    pub enlarged: f64,
    /// The findings with their evidence.
    pub findings: Vec<(Candidate, Evidence)>,
}
