//! What is distinguished in a link: stiffnesses of its section, and its own weight.

use serde::{Deserialize, Serialize};

/// Which stiffnesses of a link are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Section {
    /// One unknown: a round tube, whose torsion follows from its bending.
    Tube,
    /// Two: bending alike in both planes, and twist.
    Symmetric,
    /// Three: bending about the joint's axis, bending sideways, and twist.
    #[default]
    General,
}

/// Where the links' own weight comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OwnWeight {
    /// From the masses in the robot's description.
    #[default]
    Declared,
    /// Unknown: found from the data.
    Free,
}

impl OwnWeight {
    pub(in crate::effects) fn is_declared(&self) -> bool {
        *self == OwnWeight::Declared
    }
}

/// EI / GJ of a round tube: 1 + ν.
pub(super) const TUBE: f64 = 1.3;
