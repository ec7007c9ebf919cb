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
            Failure::Input(message) => write!(f, "error: {}", in_words(message)),
        }
    }
}

/// Every error of a library is about the input.
impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Failure::Input(error.to_string())
    }
}

/// Types as those say who never saw the program's source.
fn in_words(message: &str) -> String {
    let mut words = message.to_owned();
    for whole in ["usize", "u64", "u32", "u16", "u8"] {
        words = words.replace(&format!(", expected {whole}"), ", expected a whole number, 0 or more");
    }
    words.replace(", expected f64", ", expected a number")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_said_in_words() {
        let said = |message: &str| Failure::Input(message.into()).to_string();
        assert_eq!(
            said("a.toml:3:1: -1, expected u32"),
            "error: a.toml:3:1: -1, expected a whole number, 0 or more"
        );
        assert_eq!(said("null, expected f64"), "error: null, expected a number");
    }
}
