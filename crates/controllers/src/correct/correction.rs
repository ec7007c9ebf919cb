//! What became of a point.

use crate::program::Replacement;

/// What became of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It is replaced.
    Corrected,
    /// It stays: the correction is smaller than its uncertainty.
    NotSignificant,
    /// It stays: at a singularity of the wrist a small correction would turn joints far.
    Singular,
    /// It must not be changed, for the reason that is given.
    Refused,
}

impl Outcome {
    /// Its word in files.
    pub fn word(self) -> &'static str {
        match self {
            Outcome::Corrected => "corrected",
            Outcome::NotSignificant => "not significant",
            Outcome::Singular => "unchanged at a wrist singularity",
            Outcome::Refused => "refused",
        }
    }
}

/// The correction of a point.
#[derive(Debug, Clone)]
pub struct Correction {
    /// What becomes of it.
    pub outcome: Outcome,
    /// Why, where it is not corrected.
    pub reason: String,
    /// Joints of the nominal robot at the point, controller's values, rad or m; none where they are not known.
    pub nominal: Option<Vec<f64>>,
    /// Joints of the correction.
    pub corrected: Option<Vec<f64>>,
    /// Desired position of the tool of the measurements, measurement frame, m.
    pub desired: Option<[f64; 3]>,
    /// How far the point is displaced, m, in the axes of the robot's base.
    pub displacement: Option<[f64; 3]>,
    /// And turned, rad.
    pub rotation: Option<f64>,
    /// The real robot comes within this of the desired position with 95 %, m.
    pub within_95: Option<f64>,
    /// The new numbers.
    pub replacement: Option<Replacement>,
}

impl Correction {
    pub(super) fn refused(reason: String) -> Correction {
        Correction {
            outcome: Outcome::Refused,
            reason,
            nominal: None,
            corrected: None,
            desired: None,
            displacement: None,
            rotation: None,
            within_95: None,
            replacement: None,
        }
    }
}
