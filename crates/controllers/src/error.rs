//! What is wrong with a program.

use truepose_compensate::CompensateError;
use truepose_errormodel::ModelError;

/// Why a program is not read, or not compensated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ControllerError {
    /// The text breaks the grammar of a point statement or of the language's comments and strings.
    #[error("{line}:{column}: {message}")]
    Syntax {
        /// From 1.
        line: usize,
        /// From 1, bytes.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// The file is no program that is read.
    #[error("{0}")]
    NotAProgram(String),
    /// An option does not fit the program or the robot.
    #[error("{0}")]
    Option(String),
    /// The fit cannot be used.
    #[error("{0}")]
    Fit(String),
}

impl ControllerError {
    /// As an error in one of the further files, by its place.
    pub(crate) fn in_other(self, place: usize) -> ControllerError {
        match self {
            ControllerError::Syntax { line, column, message } => ControllerError::Syntax {
                line,
                column,
                message: format!("in further file {}: {message}", place + 1),
            },
            error => error,
        }
    }
}

impl From<CompensateError> for ControllerError {
    fn from(error: CompensateError) -> Self {
        ControllerError::Fit(error.to_string())
    }
}

impl From<ModelError> for ControllerError {
    fn from(error: ModelError) -> Self {
        ControllerError::Fit(error.to_string())
    }
}

/// A syntax error at an offset of a text.
pub(crate) fn syntax(text: &[u8], offset: usize, message: impl Into<String>) -> ControllerError {
    let before = &text[..offset.min(text.len())];
    let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
    let column = 1 + before.iter().rev().take_while(|&&byte| byte != b'\n').count();
    ControllerError::Syntax { line, column, message: message.into() }
}
