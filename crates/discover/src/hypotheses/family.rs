//! The words for what a model lacks.

use serde::{Deserialize, Serialize};

/// A kind of cause, in the words of the data contract. The order is that of simplicity: of two explanations that the data
/// cannot tell apart, the earlier one is reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
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
            Family::LinkCompliance => "link_compliance",
            Family::LoadNonlinearity => "load_nonlinearity",
            Family::Shift => "shift",
            Family::Thermal => "thermal",
            Family::Drift => "drift",
            Family::Unmodelled => "unmodelled",
        }
    }

    /// Its place in the order of simplicity. Causes that follow time in one way or another share one, and so do the two that bend
    /// the curve of a joint against its load.
    pub(crate) fn rank(self) -> Family {
        match self {
            Family::Shift | Family::Drift | Family::Thermal => Family::Shift,
            Family::Backlash | Family::LoadNonlinearity => Family::Backlash,
            other => other,
        }
    }

    /// Whether the effect follows the time or a temperature.
    pub fn belongs_to_time(self) -> bool {
        matches!(self, Family::Shift | Family::Drift | Family::Thermal)
    }

    /// Whether its first coefficient is a compliance, which cannot be negative.
    pub fn is_compliance(self) -> bool {
        matches!(self, Family::JointCompliance | Family::BaseCompliance | Family::LinkCompliance)
    }
}

impl std::fmt::Display for Family {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}
