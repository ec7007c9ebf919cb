//! Errors in everyday units: families, places, sizes with units. What is not specified (a phase, a curve, the
//! direction of a displacement) is drawn from the seed.
//!
//! Every item draws from a stream of its own, so that one more error leaves the others as they were.

mod constant;
mod elastic;
mod handling;
mod motion;
mod moving;

pub use constant::{Displacement, Geometric, LinkWeight, WrongTarget};
pub use elastic::{BaseCompliance, JointCompliance, LinkCompliance};
pub use handling::{Mislabelled, Outliers, WrongPayloads};
pub use motion::{Backlash, BacklashSide, Dragging, Guideway, LeadScrew, Transmission, Wheel};
pub use moving::{Drift, Growing, Shift, Thermal};

use crate::physics::temperature::Shop;
use crate::{Blunders, SimulateError, Truth};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Chain, JointId, JointKind};

/// All errors of a robot and of the people around it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Flaws {
    /// Random constant errors of the frames.
    pub geometric: Option<Geometric>,
    /// Constant errors with their numbers.
    pub displacement: Vec<Displacement>,
    /// True link weights where they differ from the description.
    pub link: Vec<LinkWeight>,
    /// Relative standard deviation (log-normal) of every true link mass about its description.
    pub mass_scatter: f64,
    /// Relative standard deviation (log-normal) of every stiffness about the value given.
    pub stiffness_scatter: f64,
    /// Joint compliance; with `hardens_at` not proportional to the load.
    pub joint_compliance: Vec<JointCompliance>,
    /// Links that bend and twist.
    pub link_compliance: Vec<LinkCompliance>,
    /// Base compliance.
    pub base_compliance: Option<BaseCompliance>,
    /// Errors of linear guideways.
    pub guideway: Vec<Guideway>,
    /// Slides with a screw.
    pub lead_screw: Vec<LeadScrew>,
    /// Transmission errors: gears and encoder discs.
    pub transmission: Vec<Transmission>,
    /// Backlash.
    pub backlash: Vec<Backlash>,
    /// Joints dragged along by others.
    pub coupling: Vec<Dragging>,
    /// Growth with temperature.
    pub thermal: Vec<Thermal>,
    /// Slow walks.
    pub drift: Vec<Drift>,
    /// Bumps.
    pub shift: Vec<Shift>,
    /// Payloads whose label is wrong.
    pub payload: Vec<Mislabelled>,
    /// Wrong payloads at some of the pose measurements.
    pub wrong_payloads: Option<WrongPayloads>,
    /// Targets that are not where they are declared.
    pub target: Vec<WrongTarget>,
    /// Rows that mean nothing.
    pub outliers: Option<Outliers>,
}

/// A truth in the making.
pub(crate) struct Draft<'a> {
    pub chain: &'a Chain,
    pub shop: &'a Shop,
    pub truth: Truth,
    pub blunders: Blunders,
    pub stiffness_scatter: f64,
    pub mass_scatter: f64,
}

/// An error source: how it changes the truth.
pub(crate) trait Install {
    /// Writes the flaw into the draft; what it leaves open comes from `rng`.
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError>;
}

impl Flaws {
    /// The truth and the blunders of a robot with these flaws.
    ///
    /// # Errors
    /// For a joint, frame or target that the robot lacks, an error at the wrong kind of joint, or a senseless size.
    pub fn on(&self, chain: &Chain, shop: &Shop, seed: u64) -> Result<(Truth, Blunders), SimulateError> {
        let mut draft = Draft {
            chain,
            shop,
            truth: Truth::of(chain),
            blunders: Blunders::default(),
            stiffness_scatter: self.stiffness_scatter,
            mass_scatter: self.mass_scatter,
        };
        let mut family = Family { seed, number: 0 };
        family.install(&self.geometric, &mut draft)?;
        family.install(&self.displacement, &mut draft)?;
        family.install(&self.link, &mut draft)?;
        family.install([&constant::Weights], &mut draft)?;
        family.install(&self.joint_compliance, &mut draft)?;
        family.install(&self.link_compliance, &mut draft)?;
        family.install(&self.base_compliance, &mut draft)?;
        family.install(&self.guideway, &mut draft)?;
        family.install(&self.lead_screw, &mut draft)?;
        family.install(&self.transmission, &mut draft)?;
        family.install(&self.backlash, &mut draft)?;
        family.install(&self.coupling, &mut draft)?;
        family.install(&self.thermal, &mut draft)?;
        family.install(&self.drift, &mut draft)?;
        family.install(&self.shift, &mut draft)?;
        family.install(&self.payload, &mut draft)?;
        family.install(&self.wrong_payloads, &mut draft)?;
        family.install(&self.target, &mut draft)?;
        family.install(&self.outliers, &mut draft)?;
        Ok((draft.truth, draft.blunders))
    }
}

/// The place of a family in the list above: with the number of the item it makes the stream.
struct Family {
    seed: u64,
    number: u64,
}

impl Family {
    fn install<'a, I: Install + 'a>(
        &mut self,
        flaws: impl IntoIterator<Item = &'a I>,
        draft: &mut Draft<'_>,
    ) -> Result<(), SimulateError> {
        self.number += 1;
        for (item, flaw) in (0u64..).zip(flaws) {
            let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
            rng.set_stream(self.number << 32 | item);
            flaw.install(draft, &mut rng)?;
        }
        Ok(())
    }
}

impl Draft<'_> {
    /// The joint of this name, fixed or not.
    pub fn joint(&self, name: &str) -> Result<JointId, SimulateError> {
        self.chain.joint_named(name).ok_or_else(|| SimulateError::Unknown {
            what: "joint",
            name: name.into(),
            known: self.chain.joints().iter().map(|joint| joint.name.clone()).collect(),
        })
    }

    /// The joint of this name, which has to move.
    pub fn moving(&self, name: &str, what: &'static str) -> Result<JointId, SimulateError> {
        let id = self.joint(name)?;
        if self.chain.joint(id).moves() {
            return Ok(id);
        }
        Err(SimulateError::JointKind { what, joint: name.into(), have: "fixed", need: "moving" })
    }

    /// The joint of this name, which has to be a turn or a slide.
    pub fn joint_of(
        &self,
        name: &str,
        kind: JointKind,
        what: &'static str,
    ) -> Result<JointId, SimulateError> {
        let id = self.joint(name)?;
        let have = self.chain.joint(id).kind;
        if have == kind {
            return Ok(id);
        }
        Err(SimulateError::JointKind { what, joint: name.into(), have: word(have), need: word(kind) })
    }

    /// A size of a joint's own motion: the one of two that has the unit of the joint, rad or m.
    pub fn in_joint_units(
        &self,
        name: &str,
        (mrad, mm): (Option<f64>, Option<f64>),
        what: &'static str,
    ) -> Result<(JointId, f64), SimulateError> {
        let id = self.joint(name)?;
        let have = self.chain.joint(id).kind;
        let refuse =
            |need| Err(SimulateError::JointKind { what, joint: name.into(), have: word(have), need });
        match (have, mrad, mm) {
            (JointKind::Revolute, Some(mrad), None) => Ok((id, 1e-3 * mrad)),
            (JointKind::Prismatic, None, Some(mm)) => Ok((id, 1e-3 * mm)),
            (JointKind::Revolute, ..) => refuse("prismatic (for a turn give the size in mrad alone)"),
            (JointKind::Prismatic, ..) => refuse("revolute (for a slide give the size in mm alone)"),
            (JointKind::Fixed, ..) => refuse("moving"),
        }
    }

    /// Travel or range of a joint: its limits, else ±π for a turn.
    pub fn range(&self, id: JointId) -> Result<(f64, f64), SimulateError> {
        let joint = self.chain.joint(id);
        match (joint.limits, joint.kind) {
            (Some((lower, upper)), _) if upper > lower && (upper - lower).is_finite() => Ok((lower, upper)),
            (_, JointKind::Revolute) => Ok((-std::f64::consts::PI, std::f64::consts::PI)),
            _ => Err(SimulateError::NoLimits { joint: joint.name.clone() }),
        }
    }

    /// A stiffness with its scatter.
    pub fn stiffness(&self, value: f64, rng: &mut impl Rng) -> Result<f64, SimulateError> {
        if value.is_nan() || value <= 0.0 {
            return Err(SimulateError::Size { what: "a stiffness", value, need: "positive" });
        }
        Ok(value * (self.stiffness_scatter * normal(rng)).exp())
    }
}

fn word(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Revolute => "revolute",
        JointKind::Prismatic => "prismatic",
        JointKind::Fixed => "fixed",
    }
}

/// A standard normal number.
pub(crate) fn normal(rng: &mut impl Rng) -> f64 {
    StandardNormal.sample(rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn one_more_flaw_leaves_the_others_as_they_were() {
        let chain = samples::heavy();
        let shop = Shop::steady(20.0).expect("a shop");
        let geometric = Geometric { position_mm: 0.3, angle_mrad: 0.3, ..Geometric::default() };
        let few = Flaws { geometric: Some(geometric), ..Flaws::default() };
        let mesh = |joint: &str| Transmission {
            joint: joint.into(),
            wheel: Wheel::Mesh,
            amplitude_mrad: 0.1,
            cycles: Some(40.0),
            ..Transmission::default()
        };
        let more = Flaws { transmission: vec![mesh("a1"), mesh("a2")], ..few.clone() };
        let (few, _) = few.on(&chain, &shop, 4).expect("a truth");
        let (more, _) = more.on(&chain, &shop, 4).expect("a truth");
        assert_eq!(few.frames, more.frames);
        assert_ne!(more.joints[0].transmission, more.joints[1].transmission);
    }

    #[test]
    fn places_and_kinds_are_checked() {
        let chain = samples::scara();
        let shop = Shop::steady(20.0).expect("a shop");
        let backlash = |joint: &str, mrad, mm| Flaws {
            backlash: vec![Backlash {
                joint: joint.into(),
                width_mrad: mrad,
                width_mm: mm,
                ..Backlash::default()
            }],
            ..Flaws::default()
        };
        assert!(backlash("r1", Some(0.1), None).on(&chain, &shop, 1).is_ok());
        assert!(backlash("slide", None, Some(0.1)).on(&chain, &shop, 1).is_ok());
        for wrong in [
            backlash("r9", Some(0.1), None),
            backlash("r1", None, Some(0.1)),
            backlash("slide", Some(0.1), None),
        ] {
            let error = wrong.on(&chain, &shop, 1).expect_err("a refusal").to_string();
            assert!(error.contains('`'), "{error}");
        }
        let flange = JointCompliance { joint: "flange".into(), stiffness: Some(1e5), ..Default::default() };
        let on_a_fixed_joint = Flaws { joint_compliance: vec![flange], ..Flaws::default() };
        let refused = on_a_fixed_joint.on(&samples::skewed(), &shop, 1);
        assert!(matches!(refused, Err(SimulateError::JointKind { have: "fixed", .. })));
    }
}
