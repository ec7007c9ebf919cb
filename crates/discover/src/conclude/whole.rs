//! The data as a whole, divided into training rows and a held-out test set.

use truepose_errormodel::Dataset;
use truepose_identify::Placement;

/// The data as a whole, and what was known before the loop.
pub(crate) struct Whole<'a> {
    pub data: &'a Dataset,
    pub train_rows: Vec<usize>,
    pub holdout_rows: Vec<usize>,
    pub placement: Placement,
}
