//! What may be missing in a declared model, each by its own physics, with the names that are right for it.
//!
//! *Inside* means that the vocabulary has a family for it; the physics is never that of the family's formula. *Outside* has
//! no word of its own (yet): the names listed for it are those that would send a mechanic to the right place.

use crate::prelude::*;

/// A cause. The order is that of the draws and of the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Cause {
    // Causes that the vocabulary has a family for.
    JointCompliance,
    LinkBending,
    BaseTilt,
    Backlash,
    Eccentric,
    Mesh,
    Coupling,
    Shift,
    // Causes without a word of their own.
    Dahl,
    MaxwellSlip,
    Bearing,
    Waves,
    BasePlate,
    Flange,
    WarmUp,
    Station,
    Masses,
    // Causes for which the vocabulary has a word that is no formula of the plant, in its order.
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
    #[value(name = "counterbalance")]
    Spring,
    /// All drives that carry a weight yield.
    Drives,
    /// All the usual ones at once.
    Everything,
}

/// Length of a pause, s, and the number of parts of a campaign with pauses.
pub const PAUSE: f64 = 2400.0;
pub const PARTS: usize = 4;
/// Time constants of the two sides of a column, of the length of the campaign.
pub const SIDES: [f64; 2] = [0.02, 0.2];
/// A linkage is no nearer to its dead centre over the travel of its joints, rad.
const SWING: f64 = 2.95;

impl Cause {
    /// Causes that the vocabulary has a family for.
    pub fn with_family() -> &'static [Cause] {
        &Cause::all()[..8]
    }

    /// Causes without a word of their own.
    pub fn without_word() -> &'static [Cause] {
        &Cause::all()[8..17]
    }

    /// Causes with a word that is no formula of the plant.
    pub fn with_word() -> &'static [Cause] {
        &Cause::all()[17..35]
    }

    /// Whether the vocabulary has a family for it; not of several causes at once.
    pub fn inside(self) -> Option<bool> {
        (self != Cause::Everything).then(|| !Cause::without_word().contains(&self))
    }

    /// Families that are right, and whether the joint has to be that of the cause.
    pub(super) fn families(self) -> &'static [(&'static str, bool)] {
        match self {
            Cause::JointCompliance | Cause::Creep | Cause::Lubricant => &[("joint_compliance", true)],
            Cause::Drives => &[("joint_compliance", false)],
            Cause::LinkBending | Cause::Ram => &[("link_compliance", true)],
            Cause::BaseTilt => &[("base_compliance", false)],
            Cause::Backlash | Cause::Dahl | Cause::MaxwellSlip | Cause::Wear => &[("backlash", true)],
            Cause::Eccentric | Cause::Mesh | Cause::Waves => &[("transmission", true)],
            Cause::Coupling | Cause::FourBar => &[("coupling", true)],
            Cause::Shift | Cause::Undone | Cause::Settles => &[("shift", false)],
            Cause::BasePlate => &[("base_compliance", false), ("load_nonlinearity", false)],
            Cause::WarmUp => &[("thermal", false), ("drift", false)],
            Cause::Station => &[("drift", false), ("shift", false), ("instrument", false)],
            Cause::Masses => &[("joint_compliance", false), ("load_nonlinearity", false)],
            Cause::Heating => &[("thermal", true)],
            Cause::Pauses | Cause::Gradient | Cause::WholeArm => &[("thermal", false)],
            Cause::TwoConstants => &[("drift", false)],
            Cause::Refraction | Cause::Sight => &[("instrument", false)],
            Cause::Bridge => &[("guideway", true)],
            Cause::Label => &[("payload", false)],
            Cause::Spring => &[("joint_compliance", true), ("transmission", true)],
            Cause::Bearing | Cause::Flange | Cause::TiltingBearing | Cause::Everything => {
                &[("joint_compliance", true), ("link_compliance", true), ("load_nonlinearity", true)]
            }
        }
    }

    /// Whether loads have to differ between poses for it to be visible at its place.
    pub fn needs_loads(self) -> bool {
        use Cause::*;
        let elastic = matches!(self, JointCompliance | LinkBending | BaseTilt | Drives | Bearing);
        elastic || matches!(self, Waves | BasePlate | Flange | Masses | Everything)
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

    /// Whether it is in the beam of the instrument.
    pub fn is_beam(self) -> bool {
        matches!(self, Cause::Refraction | Cause::Sight)
    }

    /// Whether it is visible where temperatures change by kelvins.
    pub fn is_thermal(self) -> bool {
        matches!(self, Cause::Gradient | Cause::WholeArm | Cause::Lubricant)
    }

    /// Pauses and thermometers of a campaign of so many seconds between poses.
    pub fn equip(self, campaign: &mut Campaign, visit_s: f64) {
        let poses = campaign.visits.len();
        if self == Cause::Pauses {
            campaign.pauses = (1..PARTS).map(|part| (part * poses / PARTS, PAUSE)).collect();
        }
        if self == Cause::Gradient {
            let duration = visit_s * poses as f64;
            for (name, part) in ["front", "back"].into_iter().zip(SIDES) {
                campaign.channels.push(ChannelPlan::Body {
                    name: name.into(),
                    lag_s: part * duration,
                    sd: 0.02,
                });
            }
        }
    }

    /// Whether movable joint number `k` can have it.
    pub fn fits(self, chain: &Chain, (k, joint): (usize, JointId), loaded: bool) -> bool {
        let turns = !slides(chain, joint);
        match self {
            Cause::JointCompliance | Cause::Creep | Cause::Lubricant | Cause::Spring => turns && loaded,
            Cause::Eccentric | Cause::Mesh | Cause::Coupling => turns,
            Cause::LinkBending | Cause::Bearing | Cause::Flange | Cause::TiltingBearing => k < 3,
            Cause::Bridge | Cause::Ram => !turns && k < 2,
            Cause::FourBar => {
                let range = |joint: JointId| chain.joint(joint).limits.map_or(9.0, |(a, b)| b - a);
                let before = k.checked_sub(1).map(|k| chain.movable()[k]);
                let before = before.filter(|joint| chain.joint(*joint).kind == JointKind::Revolute);
                turns && before.is_some_and(|before| range(joint) + range(before) < SWING)
            }
            _ => true,
        }
    }
}
