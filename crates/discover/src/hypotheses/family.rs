//! The words for what a model lacks.

use serde::{Serialize, Serializer};

/// A family of effects, in the words of files. The order is that of simplicity: of two explanations that the data cannot distinguish, the
/// earlier one is reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Family {
    /// Single rows that no repeatable effect explains.
    Outlier,
    /// One target's declared position is wrong.
    Target,
    /// Constant generalized errors.
    Geometric,
    /// A joint yields in proportion to its load.
    JointCompliance,
    /// The base yields under what it carries.
    BaseCompliance,
    /// A joint error that switches with the approach or the load.
    Backlash,
    /// A joint error periodic in the joint's own motion.
    Transmission,
    /// A joint error that depends on another joint.
    Coupling,
    /// Errors of a slide as it travels.
    Guideway,
    /// The declared payload is wrong for some of the data.
    Payload,
    /// The instrument or the log of joint values errs.
    Instrument,
    /// A link bends or twists under its wrench.
    LinkCompliance,
    /// Deflection not in proportion to the load.
    LoadNonlinearity,
    /// An error that jumps once.
    Shift,
    /// An error that follows a temperature.
    Thermal,
    /// An error that moves smoothly with time.
    Drift,
    /// A family that is not built in, by its word: that of its effect, with the prefix of whoever wrote it (`acme/encoder_gain`).
    Other(&'static str),
    /// Repeatable structure without a name.
    Unmodelled,
}

impl Family {
    /// Its word in files.
    pub fn word(self) -> &'static str {
        match self {
            Family::Outlier => "outlier",
            Family::Target => "target",
            Family::Geometric => "geometric",
            Family::JointCompliance => "joint_compliance",
            Family::BaseCompliance => "base_compliance",
            Family::Backlash => "backlash",
            Family::Transmission => "transmission",
            Family::Coupling => "coupling",
            Family::Guideway => "guideway",
            Family::Payload => "payload",
            Family::Instrument => "instrument",
            Family::LinkCompliance => "link_compliance",
            Family::LoadNonlinearity => "load_nonlinearity",
            Family::Shift => "shift",
            Family::Thermal => "thermal",
            Family::Drift => "drift",
            Family::Other(word) => word,
            Family::Unmodelled => "unmodelled",
        }
    }

    /// Whether it names a cause: all but [`Family::Unmodelled`] do.
    pub fn is_named(self) -> bool {
        self != Family::Unmodelled
    }
}

impl Serialize for Family {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}

impl std::fmt::Display for Family {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_family_of_others_is_written_as_its_word_and_is_simpler_than_none() {
        let other = Family::Other("acme/encoder_gain");
        assert_eq!(serde_json::to_string(&other).unwrap(), "\"acme/encoder_gain\"");
        assert_eq!(serde_json::to_string(&Family::LoadNonlinearity).unwrap(), "\"load_nonlinearity\"");
        assert!(Family::Drift < other && other < Family::Unmodelled);
        assert!(other.is_named() && !Family::Unmodelled.is_named());
    }
}
