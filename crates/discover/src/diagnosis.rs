//! What a discovery found: the ledger.

use crate::evidence::{Doubt, Evidence};
use crate::fallback::Withdrawn;
use crate::floor::{NoiseFloor, Verdict};
use crate::{Candidate, Family, Place, Trace};
use serde::{Deserialize, Serialize};
use truepose_errormodel::Dataset;
use truepose_identify::{Fit, Placement, Repeats, Residuals, Spread};

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

/// Errors on the training part and on the rows that took part in nothing.
#[derive(Debug, Clone, Default)]
pub struct Errors {
    /// Training rows.
    pub train: Residuals,
    /// Held-out rows.
    pub holdout: Residuals,
    /// Rows, counted within each of the two parts, that are reported as outliers.
    pub outliers: [Vec<usize>; 2],
}

impl Errors {
    /// Statistics of both parts, m.
    pub fn spreads(&self) -> (Spread, Spread) {
        (self.train.positions(), self.holdout.positions())
    }

    /// Statistics of both parts without the rows that are reported as outliers, m.
    pub fn spreads_without_outliers(&self) -> (Spread, Spread) {
        let of = |part: &Residuals, out: &[usize]| {
            let rows: Vec<usize> = (0..part.position.len()).filter(|row| !out.contains(row)).collect();
            part.positions_of(&rows)
        };
        (of(&self.train, &self.outliers[0]), of(&self.holdout, &self.outliers[1]))
    }

    /// 3-D RMS of both parts, m.
    pub(crate) fn rms(&self) -> (f64, f64) {
        let (train, holdout) = self.spreads();
        (train.rms, holdout.rms)
    }
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

/// A candidate that won a contest and was not believed.
#[derive(Debug, Clone)]
pub struct Refused {
    /// The cause.
    pub candidate: Candidate,
    /// What speaks for it.
    pub evidence: Evidence,
    /// What speaks against it.
    pub doubt: Doubt,
}

/// A cause that the data cannot test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Untestable {
    /// What kind of cause.
    pub family: Family,
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// Share of its effect that the declared model does not imitate.
    pub share: f64,
    /// 3-D RMS over the data that it would need to be seen, m; none when it does nothing at all here.
    pub detectable: Option<f64>,
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

/// Why the loop stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Stop {
    /// Nothing is left that chance would not do as well.
    NothingLeft,
    /// Something is left, but no candidate passed the tests.
    NothingConvincing,
    /// As many effects as were allowed.
    Limit,
    /// The search came back to findings that it had had before, again and again: something is left, and what it is stays undecided.
    Circling,
    /// What was found did not hold on data that the search had not seen: the declared model stands.
    Withdrawn,
    /// The caller ended it: there may be more, and nothing was judged at the end.
    Interrupted,
}
