//! What a discovery found: the ledger.

use crate::accept::evidence::{Evidence, Refused};
use crate::conclude::errors::Errors;
use crate::conclude::floor::{NoiseFloor, Verdict};
use crate::conclude::trace::point::Trace;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::screen::untestable::Untestable;
use crate::termination::Stop;
use serde::{Deserialize, Serialize};
use truepose_errormodel::Dataset;
use truepose_identify::{Fit, Placement, Repeats};

/// The result of the closed loop.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// Where base, tool and targets were found, if they were looked for.
    pub placement: Placement,
    /// Effects in the order in which they were added.
    pub findings: Vec<Finding>,
    /// Candidates that won a contest and were not believed.
    pub refused: Vec<Refused>,
    /// Fits of rivals, where they were asked for.
    pub rivals: Vec<RivalFit>,
    /// What the data cannot test: (cause, the share of it that the declared model leaves, smallest size that would be seen).
    pub untestable: Vec<Untestable>,
    /// Errors before and after.
    pub before: Errors,
    /// With everything that was found.
    pub after: Errors,
    /// Findings that were withdrawn, since the declared model predicts unseen data better.
    pub withdrawn: Option<Withdrawn>,
    /// Expected 3-D RMS of one new row if the model were perfect, and where that is known from.
    pub noise_floor: NoiseFloor,
    /// Whether the model is enough.
    pub verdict: Verdict,
    /// Pure error of repeated visits, judged with the declared model.
    pub repeats_before: Option<Repeats>,
    /// Judged with everything that was found.
    pub repeats_after: Option<Repeats>,
    /// What is left.
    pub unexplained: Unexplained,
    /// Why the loop stopped.
    pub stopped: Stop,
    /// The fit of the enlarged model on all rows, structure frozen.
    pub fit: Fit,
    /// The fit of the declared model on the training part.
    pub declared: Fit,
    /// Rows of the data that were drawn out first.
    pub holdout_rows: Vec<usize>,
    /// The data as the final fit saw it: loads corrected, outliers kept out.
    pub data: Dataset,
}

/// An effect that was found and believed.
#[derive(Debug, Clone)]
pub struct Finding {
    /// The cause and the change that takes it in.
    pub candidate: Candidate,
    /// What speaks for it.
    pub evidence: Evidence,
    /// RMS on the held-out rows before and after it was added, m.
    pub holdout: (f64, f64),
    /// RMS on the training rows before and after it was added, m.
    pub train: (f64, f64),
    /// Its sizes.
    pub parameters: Vec<Parameter>,
    /// Its shape: periods, instants, time constants, lags, loads on a flank; an interval as wide as the range in which it was looked
    /// for says that the data leaves it open.
    pub shape: Vec<Parameter>,
    /// Rivals.
    pub alternatives: Vec<Alternative>,
    /// Rows (0-based, of the whole data) that it is about: outliers, or a wrong payload.
    pub rows: Vec<usize>,
    /// What is left, traced to it and set against what drives it; none of outliers.
    pub trace: Option<Trace>,
}

/// A size with its interval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// What it is.
    pub name: String,
    /// In its unit.
    pub value: f64,
    /// SI.
    pub unit: String,
    /// 95 % interval.
    pub ci95: [f64; 2],
}

/// Another explanation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Alternative {
    /// What kind of cause.
    pub family: Family,
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// RMS on the held-out rows with it in place of the find, m.
    pub holdout: f64,
    /// How much less likely it makes the data, in −2 ln L with the price of its unknowns.
    pub behind: f64,
    /// True when this data cannot tell it from the find.
    pub equivalent: bool,
}

/// The whole model with another explanation in place of a find that this data cannot tell from it.
#[derive(Debug, Clone)]
pub struct RivalFit {
    /// Number of the find, from zero.
    pub finding: usize,
    /// What stands in its place.
    pub candidate: Candidate,
    /// Fitted to all rows, as the final model is.
    pub fit: Fit,
}

/// What is left.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Unexplained {
    /// Whether it is more than noise.
    pub significant: bool,
    /// 3-D RMS of what lies beyond the repeatability limit, m; none where no estimate of that is known.
    pub rms: Option<f64>,
    /// Its share of the variance that the declared model left, with its sign; none where no estimate of the limit is known.
    pub share_of_variance: Option<f64>,
    /// The smallest family-wise p of the last screen.
    pub p_value: f64,
    /// The best candidate's gain in −2 ln L that would have been seen at the level that was asked for.
    pub detectable_gain: f64,
}

/// On which data the enlarged model was worse than the declared one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Check {
    /// Training rows, each predicted by a refit of the same structure without its fold.
    Refits,
    /// Training rows that were not in the sample that was searched.
    UnsearchedRows,
    /// Training rows, each predicted by a run of the whole loop without its fold.
    NestedFolds,
    /// The held-out test set.
    TestSet,
}

/// Findings that were withdrawn, because the declared model predicts unseen data better.
#[derive(Debug, Clone)]
pub struct Withdrawn {
    /// Where they failed.
    pub check: Check,
    /// 3-D RMS of the declared model on the rows of that check, m.
    pub declared: f64,
    /// The same with the findings, m.
    pub enlarged: f64,
    /// The findings with what spoke for them.
    pub findings: Vec<(Candidate, Evidence)>,
}
