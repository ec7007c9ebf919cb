//! What may have been misread, and when that is said.

use crate::suspicion::decisive;

/// Below this share of the arm's length nothing is wrong with conventions; as for suspected mistakes of tables.
pub(super) const NEGLIGIBLE: f64 = 2e-3;
/// Undone, a mistake leaves no more than this share of what it left.
pub(super) const GAIN: f64 = 0.2;
/// Undone, a mistake leaves a robot that is worth a calibration: no more than this share of the arm's length.
pub(super) const GOOD: f64 = 5.0 * NEGLIGIBLE;
/// Whether a mistake, undone, explains what the description leaves (m), of an arm of this length.
pub(super) fn explains(before: f64, after: f64, length: f64) -> bool {
    (after < GAIN * before && after < GOOD * length) || decisive(before, after, length)
}

/// Orientations that the nominal robot leaves with this RMS are those of a robot that is worth a calibration, rad.
pub(super) const TURNED: f64 = 0.02;

/// What was probably done. Joints are numbers among all joints, from 0; of couplings among the movable ones.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Misreading {
    /// Parameters of the standard form (dh) were given as modified (mdh).
    MdhForDh,
    /// Parameters of the modified form (mdh) were given as standard (dh).
    DhForMdh,
    /// α and θ of the description are in another unit; the factor puts them right.
    AngleUnit {
        /// Of α and θ.
        factor: f64,
    },
    /// A parameter (`a`, `d`, `alpha`, `theta`) has the wrong sign, of one joint or of all.
    Sign {
        /// The joint; none: all joints.
        joint: Option<usize>,
        /// The parameter.
        parameter: &'static str,
    },
    /// A joint's value contains that of the joint before (FANUC, parallelograms): q_joint + sign · q_driver is meant.
    Coupling {
        /// The joint.
        joint: usize,
        /// The joint before.
        driver: usize,
        /// +1 or −1.
        sign: f64,
    },
    /// A length is wrong.
    Length {
        /// The joint.
        joint: usize,
        /// `a`, `d`, or `x`, `y`, `z` of an origin.
        parameter: &'static str,
        /// What has to be added, m.
        change: f64,
    },
    /// Orientations are in this convention, and were read as a rotation vector.
    Angles {
        /// Its word in files.
        convention: &'static str,
    },
    /// Orientations are angles of this convention, and were read as those of another one.
    OtherAngles {
        /// Its word in files.
        convention: &'static str,
    },
    /// Orientations are a rotation vector, and were read as angles.
    RotationVector,
    /// Orientations are those of the measurement frame seen from the tool.
    InverseOrientation,
    /// Positions and orientations are those of the measurement frame seen from the tool.
    InversePoses,
    /// Quaternions have their scalar last.
    ScalarLast,
    /// The declared tool is turned on the flange.
    ToolTurned {
        /// About x, y or z (0, 1, 2) of the flange.
        axis: usize,
        /// By what the declared tool has to be turned, rad.
        angle: f64,
    },
    /// A coordinate of the declared tool has the wrong sign.
    ToolSign {
        /// x, y or z (0, 1, 2).
        axis: usize,
    },
    /// The tool is not where it is declared.
    ToolElsewhere,
}

/// A mistake that, undone, explains what the nominal robot leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct Misread {
    /// What was probably done.
    pub what: Misreading,
    /// RMS with it, m (of orientations rad).
    pub before: f64,
    /// With the mistake undone.
    pub after: f64,
}

/// The better of two: what leaves a fifth less.
pub(super) fn better(best: &mut Option<Misread>, other: Misread) {
    if best.as_ref().is_none_or(|best| other.after < 0.8 * best.after) {
        *best = Some(other);
    }
}
