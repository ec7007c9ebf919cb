//! What can go wrong between data and a fit.

use thiserror::Error;
use truepose_errormodel::ModelError;
use truepose_solvers::SolveError;

/// An identification that cannot be done.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// The observer of the run ended it.
    #[error("the run was cancelled")]
    Cancelled,
    /// The model does not fit the robot or the data.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The solver refused the problem.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// Nothing was measured.
    #[error(
        "the data has {rows} rows, but not one measured position or orientation; fill the x, y, z columns"
    )]
    NothingMeasured {
        /// Rows without a measurement.
        rows: usize,
    },
    /// A visit has more rows than a block.
    #[error(
        "a visit has more than {most} rows; give its standstills numbers of their own in the `visit` column"
    )]
    LongVisit {
        /// Rows of a block.
        most: usize,
    },
    /// The solver came back without an answer.
    #[error("solver `{solver}` found no answer: {status}")]
    NoAnswer {
        /// The solver.
        solver: String,
        /// Its status, in words.
        status: String,
    },
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
    /// Too few groups of visits for the folds that were asked for.
    #[error("{have} configurations cannot be divided into {need} folds; ask for at most {have}")]
    TooFewFolds {
        /// Configurations in the data.
        have: usize,
        /// Folds asked for.
        need: usize,
    },
    /// A placement that the data cannot fix.
    #[error("{what} cannot be found from this data: {why}")]
    Placement {
        /// Base, tool or target.
        what: String,
        /// What is missing, and what would help.
        why: String,
    },
    /// A landmark whose place cannot be found.
    #[error("landmark {name}: {why}")]
    Landmark {
        /// Its name.
        name: String,
        /// Why, and what would help.
        why: String,
    },
    /// Rows at landmarks and sensors that do not determine the robot, or that cannot be planned.
    #[error("{why}")]
    Observations {
        /// Why, and what would help.
        why: String,
    },
    /// Something that cannot be done on a stream of blocks.
    #[error("this cannot be done block by block: {why}; read the data as a whole")]
    NotStreamed {
        /// What.
        why: String,
    },
}
