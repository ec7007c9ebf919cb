//! Errors.

use truepose_errormodel::ModelError;
use truepose_identify::IdentifyError;

/// Why a fit cannot be transferred, or a robot not be monitored.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UpkeepError {
    /// The data lacks what the model reads, or too little was measured.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// The model cannot be evaluated.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Too little was measured to find the installation.
    #[error("the data does not determine {what}: {advice}")]
    Undetermined {
        /// The directions that stay open.
        what: String,
        /// What to measure.
        advice: String,
    },
    /// Fewer measured numbers than unknowns of the installation.
    #[error(
        "{have} measured numbers do not determine an installation of {need} unknowns: measure more poses"
    )]
    TooFew {
        /// Measured numbers.
        have: usize,
        /// Unknowns of the installation.
        need: usize,
    },
    /// The fit does not say how well its coefficients are known, or what scatter to expect.
    #[error("the fit says nothing of {what}: identify it again from measurements")]
    NoUncertainty {
        /// What is missing.
        what: &'static str,
    },
    /// Robots that are no fleet.
    #[error("{why}")]
    Fleet {
        /// Why.
        why: String,
    },
    /// An option is out of its range.
    #[error("{option} is {value}; it has to be {expected}")]
    Option {
        /// Its name.
        option: &'static str,
        /// As given.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
}
