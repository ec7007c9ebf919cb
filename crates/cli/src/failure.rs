//! The two kinds of failure of a run.

use std::any::Any;
use std::fmt;
use truepose_workflow::WorkflowError;

/// Why a run failed.
#[derive(Debug)]
pub enum Failure {
    /// A required criterion is not met: exit code 1.
    Criterion(String),
    /// The input or the usage is wrong: exit code 2.
    Input(String),
    /// The robot that is monitored has changed, as the output says: exit code 3.
    Changed,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Criterion(message) => write!(f, "not met: {}", short(message)),
            // Several errors stand one a line, and each is shortened by itself.
            Failure::Input(message) if message.lines().nth(1).is_some() => {
                let lines: Vec<String> = message.lines().take(LINES).map(short).collect();
                write!(f, "error: {}", plain_types(&lines.join("\n       ")))
            }
            Failure::Changed => write!(f, "the robot has changed"),
            Failure::Input(message) => write!(f, "error: {}", plain_types(&short(message))),
        }
    }
}

/// Every error of a library is about the input. One about an option names it as it is typed.
impl<E: std::error::Error + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        let option = match (&error as &dyn Any).downcast_ref() {
            Some(WorkflowError::InvalidOption { .. }) => "--",
            _ => "",
        };
        Failure::Input(format!("{option}{error}"))
    }
}

/// A message that quotes a file at length, without its middle.
fn short(message: &str) -> String {
    let count = message.chars().count();
    if count <= LONGEST {
        return message.to_owned();
    }
    let head: String = message.chars().take(LONGEST - END).collect();
    let tail: String = message.chars().skip(count - END).collect();
    format!("{head} … {tail}")
}

/// Characters of a message, at most, and those that are kept of the end of a longer one.
const LONGEST: usize = 2000;
/// Lines of a message, at most.
const LINES: usize = 80;
const END: usize = 300;

/// Replaces names of types by plain English.
fn plain_types(message: &str) -> String {
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
    fn long_messages_lose_their_middle() {
        let long = format!("a.csv:1: column `{}` is no column", "é".repeat(100_000));
        let shown = Failure::Input(long).to_string();
        assert!(shown.starts_with("error: a.csv:1: column `é") && shown.ends_with("é` is no column"));
        assert!(shown.chars().count() < 2020);
    }

    #[test]
    fn names_of_types_are_replaced() {
        let shown = |message: &str| Failure::Input(message.into()).to_string();
        assert_eq!(
            shown("a.toml:3:1: -1, expected u32"),
            "error: a.toml:3:1: -1, expected a whole number, 0 or more"
        );
        assert_eq!(shown("null, expected f64"), "error: null, expected a number");
    }
}
