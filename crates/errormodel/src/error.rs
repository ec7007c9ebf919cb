//! What can be wrong with a model, or with data for it.

use crate::size::{MOST_UNKNOWNS, memory};
use thiserror::Error;

/// A model that does not fit its robot, or data that does not fit the model.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A family that the registry does not know.
    #[error("unknown effect family `{kind}`; known families: {}", known.join(", "))]
    UnknownFamily {
        /// What was asked for.
        kind: String,
        /// What there is.
        known: Vec<String>,
    },
    /// Parameters of an effect that do not parse.
    #[error("effect `{kind}`: {reason}")]
    Parameters {
        /// The effect's family.
        kind: String,
        /// What is wrong with which parameter.
        reason: String,
    },
    /// More unknowns than a fit has room and time for.
    #[error(
        "{what} has {unknowns} unknowns, whose fit would take {}; at most {MOST_UNKNOWNS} are supported ({})",
        memory(*unknowns),
        memory(MOST_UNKNOWNS)
    )]
    TooLarge {
        /// The effect, or the model.
        what: String,
        /// How many it has.
        unknowns: usize,
    },
    /// An effect that asks for a joint, frame or target that the robot lacks.
    #[error("effect `{kind}` refers to {what} {number}, but the robot has {count}")]
    NoSuchPlace {
        /// The effect's family.
        kind: String,
        /// `joint`, `frame` or `target`.
        what: &'static str,
        /// Its number.
        number: usize,
        /// How many there are.
        count: usize,
    },
    /// An effect of a joint's motion at a joint that does not move.
    #[error("effect `{kind}` acts on the motion of joint `{joint}`, which is fixed")]
    JointIsFixed {
        /// The effect's family.
        kind: String,
        /// The joint.
        joint: String,
    },
    /// A signal that the model needs and the data lacks.
    #[error("effect `{kind}` needs {signal}, which the data does not have{}", hint(signal, have))]
    MissingSignal {
        /// The effect's family.
        kind: String,
        /// The missing signal in words.
        signal: String,
        /// Channels that the data has.
        have: Vec<String>,
    },
    /// A channel whose values are in another unit than those that the model was fitted on.
    #[error("channel `{channel}` is in [{have}], but the model was fitted on [{need}]")]
    ChannelUnit {
        /// The channel.
        channel: String,
        /// Unit of the data.
        have: String,
        /// Unit at fit time.
        need: String,
    },
    /// A measurement that does not fit the robot or the rows before it.
    #[error("measurement {row}: {reason}")]
    Measurement {
        /// Its number, from zero.
        row: usize,
        /// What is wrong with which value.
        reason: String,
    },
    /// A matrix that should be a covariance is not symmetric, not finite, or has a negative variance in some direction.
    #[error(
        "the covariance is not symmetric, has a negative variance in some direction, or a number that is not finite"
    )]
    NotACovariance,
    /// A column, coefficient vector or matrix of the wrong size.
    #[error("{what}: {have} where {need} are needed")]
    Shape {
        /// Which quantity.
        what: &'static str,
        /// Its size.
        have: usize,
        /// The size it should have.
        need: usize,
    },
}

/// Refuses more unknowns than [`MOST_UNKNOWNS`].
///
/// # Errors
/// [`ModelError::TooLarge`] with this name.
pub(crate) fn bounded(what: impl FnOnce() -> String, unknowns: usize) -> Result<(), ModelError> {
    if unknowns <= MOST_UNKNOWNS { Ok(()) } else { Err(ModelError::TooLarge { what: what(), unknowns }) }
}

fn hint(signal: &str, have: &[String]) -> String {
    let known = if have.is_empty() { String::new() } else { format!(" (its channels: {})", have.join(", ")) };
    // A channel that follows late is made from the one that it follows.
    match signal.strip_prefix("a channel `").and_then(|name| name.split_once("~lag=")) {
        Some((source, _)) => format!("{known}; it is made from `{source}` and `time`, where both are there"),
        None if (signal.starts_with("a channel `z_") && signal.contains("~w="))
            || signal.starts_with("a channel `step~") =>
        {
            format!("{known}; it is made from the joint and the order of poses, or by the controller")
        }
        None => known,
    }
}
