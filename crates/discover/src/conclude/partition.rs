//! Partition of the data into training rows and a held-out test set.

use crate::conclude::stated::StatedScale;
use truepose_errormodel::Dataset;
use truepose_identify::Placement;

/// All data with its partition (rows 0-based), and the placement, which precede the search.
pub(crate) struct Partition<'a> {
    pub data: &'a Dataset,
    pub train_rows: Vec<usize>,
    pub holdout_rows: Vec<usize>,
    pub placement: Placement,
    /// Factors with which the stated standard deviations of `data` were multiplied.
    pub stated_scale: StatedScale,
}
