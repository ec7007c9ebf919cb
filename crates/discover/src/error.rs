//! What can go wrong in a discovery.

use thiserror::Error;
use truepose_errormodel::ModelError;
use truepose_identify::IdentifyError;

/// A discovery that cannot be done.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DiscoverError {
    /// A fit is not possible.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// An option out of its range.
    #[error("option `{option}` is {value}, but has to be {expected}")]
    Option {
        /// The option.
        option: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// Too little data for the question.
    #[error(
        "too few visits to look for what a model of rank {rank} lacks: {have}, and at least {need} are needed"
    )]
    TooFewVisits {
        /// Visits in the data.
        have: usize,
        /// Rank of the declared model.
        rank: usize,
        /// How many are needed.
        need: usize,
    },
}

impl From<ModelError> for DiscoverError {
    fn from(error: ModelError) -> Self {
        DiscoverError::Identify(error.into())
    }
}

impl From<truepose_solvers::SolveError> for DiscoverError {
    fn from(error: truepose_solvers::SolveError) -> Self {
        DiscoverError::Identify(error.into())
    }
}
