//! Errors of a discovery.

use thiserror::Error;
use truepose_errormodel::ModelError;
use truepose_identify::IdentifyError;

/// Why a discovery is not possible.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DiscoverError {
    /// A fit failed.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// An option out of its range.
    #[error("option `{option}` is {value}, but has to be {expected}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        expected: &'static str,
    },
    /// Too few poses for a search.
    #[error(
        "too few poses for a search beside a declared model of rank {rank}: {have}, at least {need} are needed"
    )]
    TooFewPoses {
        /// Poses in the training data.
        have: usize,
        /// Rank of the declared model.
        rank: usize,
        /// Fewest poses of a search.
        need: usize,
    },
    /// Runs that are not those of all folds of one nested cross-validation.
    #[error("nested cross-validation: {0}")]
    Folds(String),
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
