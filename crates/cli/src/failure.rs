//! The two ways in which a run can end other than well.

use std::fmt;

/// Why a run did not end well.
#[derive(Debug)]
pub enum Failure {
    /// A criterion that was asked for is not met: exit code 1.
    Criterion(String),
    /// The input or the usage is wrong: exit code 2.
    Input(String),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Criterion(message) => write!(f, "not met: {message}"),
            Failure::Input(message) => write!(f, "error: {message}"),
        }
    }
}

/// Every error of a library is about the input.
impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Failure::Input(error.to_string())
    }
}
