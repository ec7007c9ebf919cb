//! What may be missing in a declared model, each by its own physics, with the names that are right for it.
//!
//! *Inside* means that the vocabulary has a family for it; the physics is never that of the family's formula. *Outside* has
//! no word of its own (yet): the names listed for it are those that would send a mechanic to the right place.

/// A cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    JointCompliance,
    LinkBending,
    BaseTilt,
    /// All drives that carry a weight yield.
    Drives,
    Backlash,
    Eccentric,
    Mesh,
    Coupling,
    Shift,
    Dahl,
    MaxwellSlip,
    Bearing,
    Waves,
    BasePlate,
    Flange,
    WarmUp,
    Station,
    Masses,
    Creep,
    Heating,
    Pauses,
    Gradient,
    WholeArm,
    Lubricant,
    TwoConstants,
    Undone,
    Settles,
    TiltingBearing,
    Refraction,
    Sight,
    Bridge,
    Ram,
    Wear,
    FourBar,
    Label,
    Spring,
    /// All the usual ones at once.
    Everything,
}

/// Causes that the vocabulary has a family for.
pub const INSIDE: [Cause; 8] = [
    Cause::JointCompliance,
    Cause::LinkBending,
    Cause::BaseTilt,
    Cause::Backlash,
    Cause::Eccentric,
    Cause::Mesh,
    Cause::Coupling,
    Cause::Shift,
];

/// Causes for which the vocabulary has a word that is no formula of the plant, in its order.
pub const WORDS: [Cause; 18] = [
    Cause::Creep,
    Cause::Heating,
    Cause::Pauses,
    Cause::Gradient,
    Cause::WholeArm,
    Cause::Lubricant,
    Cause::TwoConstants,
    Cause::Undone,
    Cause::Settles,
    Cause::TiltingBearing,
    Cause::Refraction,
    Cause::Sight,
    Cause::Bridge,
    Cause::Ram,
    Cause::Wear,
    Cause::FourBar,
    Cause::Label,
    Cause::Spring,
];

/// Causes without a word of their own.
pub const OUTSIDE: [Cause; 9] = [
    Cause::Dahl,
    Cause::MaxwellSlip,
    Cause::Bearing,
    Cause::Waves,
    Cause::BasePlate,
    Cause::Flange,
    Cause::WarmUp,
    Cause::Station,
    Cause::Masses,
];

impl Cause {
    pub fn word(self) -> &'static str {
        match self {
            Cause::JointCompliance => "joint_compliance",
            Cause::LinkBending => "link_bending",
            Cause::BaseTilt => "base_tilt",
            Cause::Drives => "drives",
            Cause::Backlash => "backlash",
            Cause::Eccentric => "eccentric",
            Cause::Mesh => "mesh",
            Cause::Coupling => "coupling",
            Cause::Shift => "shift",
            Cause::Dahl => "dahl",
            Cause::MaxwellSlip => "maxwell_slip",
            Cause::Bearing => "bearing",
            Cause::Waves => "waves",
            Cause::BasePlate => "base_plate",
            Cause::Flange => "flange",
            Cause::WarmUp => "warm_up",
            Cause::Station => "station",
            Cause::Masses => "masses",
            Cause::Everything => "everything",
            other => other.word_of_row(),
        }
    }

    /// Whether the vocabulary has a family for it; not of several causes at once.
    pub fn inside(self) -> Option<bool> {
        (self != Cause::Everything)
            .then(|| INSIDE.contains(&self) || WORDS.contains(&self) || self == Cause::Drives)
    }

    /// Families that are right, and whether the joint has to be that of the cause.
    pub(super) fn families(self) -> &'static [(&'static str, bool)] {
        match self {
            Cause::JointCompliance => &[("joint_compliance", true)],
            Cause::Drives => &[("joint_compliance", false)],
            Cause::LinkBending => &[("link_compliance", true)],
            Cause::BaseTilt => &[("base_compliance", false)],
            Cause::Backlash | Cause::Dahl | Cause::MaxwellSlip => &[("backlash", true)],
            Cause::Eccentric | Cause::Mesh | Cause::Waves => &[("transmission", true)],
            Cause::Coupling => &[("coupling", true)],
            Cause::Shift => &[("shift", false)],
            Cause::Bearing | Cause::Flange => {
                &[("joint_compliance", true), ("link_compliance", true), ("load_nonlinearity", true)]
            }
            Cause::BasePlate => &[("base_compliance", false), ("load_nonlinearity", false)],
            Cause::WarmUp => &[("thermal", false), ("drift", false)],
            Cause::Station => &[("drift", false), ("shift", false), ("instrument", false)],
            Cause::Masses => &[("joint_compliance", false), ("load_nonlinearity", false)],
            other => other.families_of_words(),
        }
    }

    /// Whether loads have to differ between poses for it to be visible at its place.
    pub fn needs_loads(self) -> bool {
        matches!(
            self,
            Cause::JointCompliance
                | Cause::LinkBending
                | Cause::BaseTilt
                | Cause::Drives
                | Cause::Bearing
                | Cause::Waves
                | Cause::BasePlate
                | Cause::Flange
                | Cause::Masses
                | Cause::Everything
        )
    }

    /// Whether the declared model has joint compliances (masses matter through them alone).
    pub fn needs_compliance(self) -> bool {
        matches!(self, Cause::Masses | Cause::Everything)
    }

    /// Declared compliance of the robot over that of other robots: masses matter where drives deflect, as those of light arms.
    pub fn softness(self) -> f64 {
        match self {
            Cause::Masses => 20.0,
            Cause::Lubricant | Cause::Label | Cause::Spring => 8.0,
            Cause::Everything => 3.0,
            _ => 1.0,
        }
    }

    /// Whether its size is given by what it is (10 % of each mass), not by the noise.
    pub fn has_a_size_of_its_own(self) -> bool {
        self == Cause::Masses
    }

    /// Whether the robot's own errors are unchanged by it: the instrument moves.
    pub fn is_instrument(self) -> bool {
        self == Cause::Station
    }
}
