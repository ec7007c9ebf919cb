//! Partition of the data into rows that are searched and rows on which the model is judged.

use crate::conclude::stated::StatedScale;
use serde::{Deserialize, Serialize};
use truepose_errormodel::{Dataset, configurations};
use truepose_identify::{Folds, IdentifyError, Placement, Split};

/// Which rows the held-out errors come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum HeldOut {
    /// A test set that was drawn before anything was fitted.
    TestSet,
    /// All rows, each predicted by a run of the whole search without its fold: where poses are few, and a test set would cost the search its
    /// power (Stone 1974).
    NestedFolds,
    /// All rows, each predicted by a refit of the findings without its fold: of a run that was ended before its nested folds.
    Refits,
}

/// (rows of a fit, rows that it is judged on), 0-based.
pub(crate) type RowSplit = (Vec<usize>, Vec<usize>);

/// All data with its partition (rows 0-based), and the placement, which precede the search.
pub(crate) struct Partition<'a> {
    pub data: &'a Dataset,
    /// Rows that are searched.
    pub train_rows: Vec<usize>,
    /// Rows with a held-out error: the test set, or all rows.
    pub holdout_rows: Vec<usize>,
    pub held_out: HeldOut,
    pub placement: Placement,
    /// Factors with which the stated standard deviations of `data` were multiplied.
    pub stated_scale: StatedScale,
}

impl Partition<'_> {
    /// One for each fit of a fixed structure.
    ///
    /// # Errors
    /// When there are too few configurations for `folds`.
    pub fn splits(&self, folds: usize, seed: u64) -> Result<Vec<RowSplit>, IdentifyError> {
        match self.held_out {
            HeldOut::TestSet => Ok(vec![(self.train_rows.clone(), self.holdout_rows.clone())]),
            HeldOut::NestedFolds | HeldOut::Refits => by_folds(self.data, folds, seed),
        }
    }
}

/// (training, test) rows of random folds of whole configurations.
pub(crate) fn by_folds(data: &Dataset, folds: usize, seed: u64) -> Result<Vec<RowSplit>, IdentifyError> {
    let count = configurations(data).iter().max().map_or(0, |last| last + 1);
    let folds = Folds::new(data, &Split::Random { folds: folds.min(count), seed })?;
    let split = |fold| (0..data.len()).partition(|&row| folds.of_visit[data.visit[row]] != fold);
    Ok((0..folds.count).map(split).collect())
}
