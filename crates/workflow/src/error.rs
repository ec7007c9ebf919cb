//! Why a piece of work could not be done.

use std::path::PathBuf;
use thiserror::Error;
use truepose_compensate::CompensateError;
use truepose_controllers::ControllerError;
use truepose_discover::DiscoverError;
use truepose_errormodel::ModelError;
use truepose_identify::IdentifyError;
use truepose_io::IoError;
use truepose_kinematics::ChainError;
use truepose_upkeep::UpkeepError;

/// Errors of the workflow.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WorkflowError {
    /// A file cannot be read or written, or its content is wrong.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A robot cannot be described so.
    #[error(transparent)]
    Chain(#[from] ChainError),
    /// A model does not fit its robot or its data.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A fit fails.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// A search fails.
    #[error(transparent)]
    Discover(#[from] DiscoverError),
    /// A correction fails.
    #[error(transparent)]
    Compensate(#[from] CompensateError),
    /// A robot program cannot be read or rewritten.
    #[error(transparent)]
    Controller(#[from] ControllerError),
    /// A fit cannot be carried to another installation.
    #[error(transparent)]
    Upkeep(#[from] UpkeepError),
    /// An error about a file, or about its data.
    #[error("{}: {source}", file.display())]
    About {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        source: Box<WorkflowError>,
    },
    /// An option of the request cannot be used so.
    #[error("{option}: {message}")]
    InvalidOption {
        /// Its name, words separated by `-`, without the dashes of a command line.
        option: &'static str,
        /// What is wrong.
        message: String,
    },
    /// The input cannot be used; several lines where several things are wrong.
    #[error("{0}")]
    Input(String),
}

impl WorkflowError {
    /// Whether an observer ended the run.
    pub fn is_cancelled(&self) -> bool {
        matches!(
            self,
            WorkflowError::Identify(IdentifyError::Cancelled)
                | WorkflowError::Discover(DiscoverError::Identify(IdentifyError::Cancelled))
        )
    }

    /// Of an option of the request.
    pub(crate) fn option(option: &'static str, message: impl Into<String>) -> Self {
        WorkflowError::InvalidOption { option, message: message.into() }
    }

    /// The same error about this file.
    pub(crate) fn about(file: impl Into<PathBuf>, source: impl Into<WorkflowError>) -> Self {
        WorkflowError::About { file: file.into(), source: Box::new(source.into()) }
    }
}
