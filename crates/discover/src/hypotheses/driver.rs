//! What drives the error that a hypothesis describes.

use std::fmt;

/// A quantity that drives an error. Two findings with a driver in common may be halves of one cause; a finding is drawn against its driver.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Driver {
    /// The value of a joint, by its name; rad or m.
    Joint(String),
    /// The load about or along the axis of a joint, by its name; N·m or N.
    JointLoad(String),
    /// The direction in which a joint last moved, by its name.
    Approach(String),
    /// The wrench that a part of the robot carries; N or N·m.
    Wrench,
    /// A channel, by its name; in its unit.
    Channel(String),
    /// The time, s.
    Time,
    /// The pose measurement (`visit` in files), by its number.
    Pose,
}

/// The word that a trace is published with.
impl fmt::Display for Driver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Driver::Joint(name) | Driver::Channel(name) => f.write_str(name),
            Driver::JointLoad(joint) => write!(f, "load on {joint}"),
            Driver::Approach(joint) => write!(f, "approach of {joint}"),
            Driver::Wrench => f.write_str("wrench"),
            Driver::Time => f.write_str("time"),
            Driver::Pose => f.write_str("visit"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_published_traces() {
        let words = [
            (Driver::Joint("a2".into()), "a2"),
            (Driver::JointLoad("a2".into()), "load on a2"),
            (Driver::Approach("a2".into()), "approach of a2"),
            (Driver::Channel("oil".into()), "oil"),
            (Driver::Time, "time"),
            (Driver::Pose, "visit"),
        ];
        for (driver, word) in words {
            assert_eq!(driver.to_string(), word);
        }
    }
}
