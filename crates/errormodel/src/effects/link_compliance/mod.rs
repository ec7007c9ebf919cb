//! A link that bends and twists under the wrench at its tip and under its own weight, as a beam.
//!
//! ```text
//!      joint j                      joint j+1          undeformed: dashes
//!         ●┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄┄●
//!          ━━━━━━━━━━━━━━━━━━━━━━━━━┓  │ δ = I_1 × x̂ / EI
//!                                   ┗━━● θ = I_0 / EI,  φ = x̂ · I_0 / GJ
//!      o_j (MDH, origin)            o_j (DH)
//!
//! E_j:  φ_j = θ,   t_j = δ − θ × (tip − o_j)              in the axes of frame j
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | I_0, I_1 | `beam::Beam`: bending moment summed over the length | N·m², N·m³ |
//! | 1/EI, 1/GJ | the unknowns | 1/(N·m²) |
//! | root, tip | [`truepose_kinematics::Span`] | m |
//!
//! Frame j is fixed to link j in every convention, at the link's tip with DH and at its root with MDH and origin + axis:
//! `E_j` carries the deflection, with the lever from o_j to the tip. Where a link begins and ends stands in
//! [`truepose_kinematics::Chain::link`]: what lies between the frames of its two joints, and a tool's length in a wrist where they
//! coincide. Descriptions that put the joints in the same places bend alike.
//!
//! Which unknowns: few are robust, but a section is rarely round, and `across` says in which planes. So a `general` section
//! has a stiffness for each plane and one for torsion; `symmetric` has one for both planes; a `tube` ties torsion to
//! it as well (GJ = EI / 1.3, Poisson's ratio 0.3).
//!
//! A ram bends over the length that is out of its guide (`ram`): see `ram`.
//!
//! Links of declared mass bend under it (spread evenly about its centre). With `own_weight = "free"` the declared mass
//! is left aside and two more unknowns a plane stand for it: a mass spread evenly over the link, and a mass at its tip
//! for links whose weight is not declared either; each times 1/EI, in kg/(N·m²), times gravity. A mass at the tip has no arm; that of an elbow
//! has. `links` counts the links beyond that have arms, each a moment at the tip:
//!
//! ```text
//! M_tip += Σ_a (h_a / EI) · a × g        a: two across this link, two across the axis of each of the `links` ones beyond (a slide: one)
//! ```
//!
//! with h_a the first moment of what lies there, as in [`super::JointCompliance`]; the unknowns h_a / EI are in kg·m/(N·m²).

mod beam;
mod ram;
mod section;
mod wide;

pub use section::{OwnWeight, Section};

use super::checks::{joint_moves, listed_once};
use super::free_weight;
use super::robot_size::robot_size;
use super::travel::free;
use crate::lanes::{LaneEmission, LanePosture};
use crate::{Column, Effect, Emission, ModelError, NonlinearParameter, Search};
use beam::{Beam, NO_LENGTH};
use section::TUBE;
use serde::{Deserialize, Serialize};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Axis, Chain, JointId, Posture, Site, Wrench};
use wide::Bending;

/// Compliance of links as beams.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkCompliance {
    /// The joints in front of the links; all with a link of some length when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<Vec<JointId>>,
    /// Which stiffnesses are told apart.
    #[serde(default)]
    pub section: Section,
    /// Where the links' own weight comes from.
    #[serde(default)]
    pub own_weight: OwnWeight,
    /// How many links beyond have free weights with arms of their own.
    #[serde(default, skip_serializing_if = "no_links")]
    pub links: usize,
    /// Of one slide whose part bends that is out of its guide: free length at zero, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ram: Option<f64>,
    /// Between which lengths `ram` is to be found, m; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ram_range: Option<[f64; 2]>,
    /// Whether a ram is drawn in as its joint's value grows.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub retracts: bool,
}

fn no_links(links: &usize) -> bool {
    *links == 0
}

/// Weight that is expected of a part, kg.
const WEIGHT: f64 = 50.0;
/// Links shorter than this share of the arm are rigid unless they are asked for.
const SHORT: f64 = 0.03;

impl LinkCompliance {
    /// Of the link behind one joint.
    pub fn of(joint: JointId) -> Self {
        LinkCompliance { joints: Some(vec![joint]), ..LinkCompliance::default() }
    }

    fn for_each_joint(&self, chain: &Chain, mut each: impl FnMut(JointId)) {
        match &self.joints {
            Some(joints) => joints.iter().for_each(|&joint| each(joint)),
            None => {
                let short = SHORT * chain.characteristic_length();
                chain.movable().iter().filter(|&&j| chain.link_length(j) > short).for_each(|&j| each(j));
            }
        }
    }

    fn planes(&self) -> usize {
        if self.section == Section::General { 2 } else { 1 }
    }

    fn width(&self, chain: &Chain, joint: JointId) -> usize {
        let stiffnesses = self.planes() + usize::from(self.section != Section::Tube);
        let arms: usize = self.beyond(chain, joint).map(|(_, arms)| arms).sum();
        stiffnesses + if self.own_weight == OwnWeight::Free { (2 + arms) * self.planes() } else { 0 }
    }

    /// The joints whose links have weights with arms, the link's own first, and how many arms.
    fn beyond<'a>(
        &self,
        chain: &'a Chain,
        joint: JointId,
    ) -> impl Iterator<Item = (JointId, usize)> + use<'a> {
        let links = if self.own_weight == OwnWeight::Free { self.links } else { 0 };
        let own = (links > 0).then_some((joint, 2));
        let later = chain.movable().iter().copied().filter(move |&k| k > joint).take(links);
        own.into_iter().chain(later.map(|k| (k, free_weight::numbers(chain.joint(k)))))
    }

    /// Displacement and rotation of the tip by each plane in turn.
    fn bend(
        &self,
        beam: &Beam,
        axis: &Vector3<f64>,
        mut each: impl FnMut(usize, Vector3<f64>, Vector3<f64>),
    ) {
        if self.section == Section::General {
            let (sag, slope) = beam.bent_about(axis);
            each(0, sag, slope);
            let (sag, slope) = beam.bent_about(&beam.along().cross(axis));
            each(1, sag, slope);
        } else {
            let (sag, slope) = beam.bent();
            each(0, sag, slope);
        }
    }
}

impl Effect for LinkCompliance {
    const FAMILY: &'static str = "link_compliance";
    const ABOUT: &'static str = "a link bends and twists under the wrench at its tip and under its own weight; a ram with its extension (ram)";

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let mut columns = Vec::new();
        if self.ram.is_some() {
            return self.column_of_ram(chain);
        }
        self.for_each_joint(chain, |joint| {
            let name = &chain.joint(joint).name;
            // A tip force of 500 N makes it sag by a thousandth of its length.
            let expected = 6e-6 / chain.link_length(joint).max(0.01 * robot_size(chain)).powi(2);
            let planes: &[&str] =
                if self.section == Section::General { &[" about its axis", " sideways"] } else { &[""] };
            let mut add = |name: String, unit: &str, scale: f64, lower: f64| {
                columns.push(Column::new(name, unit, scale).within(lower, f64::INFINITY));
            };
            for plane in planes {
                add(format!("bending {name}{plane}"), "1/(N*m^2)", expected, 0.0);
            }
            if self.section != Section::Tube {
                add(format!("twist {name}"), "1/(N*m^2)", TUBE * expected, 0.0);
            }
            if self.own_weight == OwnWeight::Free {
                for what in ["own weight", "weight beyond"] {
                    for plane in planes {
                        let name = format!("{what} {name}{plane}");
                        add(name, "kg/(N*m^2)", WEIGHT * expected, f64::NEG_INFINITY);
                    }
                }
            }
            let arm = chain.link_length(joint).max(0.01 * robot_size(chain));
            for (other, arms) in self.beyond(chain, joint) {
                for number in 1..=arms {
                    for plane in planes {
                        let other = &chain.joint(other).name;
                        let name = format!("weight of {other} on {name} {number}{plane}");
                        add(name, "kg*m/(N*m^2)", WEIGHT * arm * expected, f64::NEG_INFINITY);
                    }
                }
            }
        });
        columns
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let chain = at.chain();
        if let Some(length) = self.ram {
            return self.eval_ram(length, at, out);
        }
        let gravity = chain.gravity_in_measurement_frame();
        let planes = self.planes();
        let mut first = 0;
        self.for_each_joint(chain, |joint| {
            let column = first;
            first += self.width(chain, joint);
            let span = at.span(joint);
            let way = span.tip - span.root;
            let Some(bare) = Beam::new(&way) else { return };
            let frame = chain.frame_after(joint);
            let home = at.frame(frame);
            let lever = span.tip - home.translation;
            let mut put = |column: usize, sag: Vector3<f64>, turn: Vector3<f64>| {
                let shift = home.rotation.tr_mul(&(sag - turn.cross(&lever)));
                let turn = home.rotation.tr_mul(&turn);
                for axis in Axis::ALL {
                    let part = if axis.is_rotation() { turn } else { shift };
                    out.push(column, Site::Frame(frame, axis), part[axis.direction()]);
                }
            };

            let mut loaded = bare.with_tip(&at.tip_wrench(&span));
            if self.own_weight == OwnWeight::Declared {
                for part in chain.link_parts(joint) {
                    if let Some(link) = &chain.joint(part).link {
                        let centre = at.frame(chain.frame_after(part)).apply(&link.com) - span.root;
                        loaded = loaded.with_mass(link.mass, &centre, &gravity);
                    }
                }
            }
            let axis = across(&way, joint, span.next, at);
            let twist = loaded.twisted();
            self.bend(&loaded, &axis, |plane, sag, slope| {
                let tied = if self.section == Section::Tube { twist * TUBE } else { Vector3::zeros() };
                put(column + plane, sag, slope + tied);
            });
            let mut column = column + planes;
            if self.section != Section::Tube {
                put(column, Vector3::zeros(), twist);
                column += 1;
            }
            if self.own_weight == OwnWeight::Free {
                let own = bare.with_mass(1.0, &(way / 2.0), &gravity);
                let beyond = bare.with_tip(&Wrench { force: gravity, moment: Vector3::zeros() });
                self.bend(&own, &axis, |plane, sag, slope| put(column + plane, sag, slope));
                self.bend(&beyond, &axis, |plane, sag, slope| put(column + planes + plane, sag, slope));
                column += 2 * planes;
            }
            for (other, _) in self.beyond(chain, joint) {
                let sideways = bare.along().cross(&axis);
                let own = [Some(axis), Some(sideways)];
                let arms = if other == joint { own } else { free_weight::arms(at, other) };
                for arm in arms.into_iter().flatten() {
                    let hung =
                        bare.with_tip(&Wrench { force: Vector3::zeros(), moment: arm.cross(&gravity) });
                    let twist =
                        if self.section == Section::Tube { hung.twisted() * TUBE } else { Vector3::zeros() };
                    self.bend(&hung, &axis, |plane, sag, slope| put(column + plane, sag, slope + twist));
                    column += planes;
                }
            }
        });
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        if self.ram.is_some() || self.links > 0 || !at.chain().is_serial() {
            return false;
        }
        let chain = at.chain();
        let mut first = 0;
        self.for_each_joint(chain, |joint| {
            let (column, width) = (first, self.width(chain, joint));
            first += width;
            if chain.link_length(joint) <= NO_LENGTH {
                return;
            }
            let (section, own_weight) = (self.section, self.own_weight);
            let bend =
                |into: &mut [f64]| at.arch().dispatch(Bending { section, own_weight, at, joint, out: into });
            let frame = chain.frame_after(joint);
            for (k, value) in out.values(6 * width, bend).enumerate() {
                out.push(column + k / 6, Site::Frame(frame, Axis::ALL[k % 6]), value);
            }
        });
        true
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        self.validate_ram(chain)?;
        if self.ram.is_some() {
            return Ok(());
        }
        for &joint in self.joints.iter().flatten() {
            joint_moves(Self::FAMILY, joint, chain)?;
            if chain.link_length(joint) < 1e-6 {
                let name = &chain.joint(joint).name;
                let reason = format!("the link behind joint `{name}` has no length, so that it cannot bend");
                return Err(ModelError::Parameters { kind: Self::FAMILY.into(), reason });
            }
        }
        listed_once(Self::FAMILY, self.joints.as_deref(), chain)
    }

    fn shape(&self) -> Vec<NonlinearParameter> {
        self.ram.map_or_else(Vec::new, |length| free("ram", "m", length, self.ram_range, Search::Smooth))
    }

    fn with_nonlinear(&self, values: &[f64]) -> Self {
        LinkCompliance { ram: self.ram.map(|ram| values.first().copied().unwrap_or(ram)), ..self.clone() }
    }
}

/// A unit vector across the link about which it bends first: its joint's axis, or the next one's where the link lies
/// along its own axis, made square to the link.
fn across(way: &Vector3<f64>, joint: JointId, next: Option<JointId>, at: &Posture<'_>) -> Vector3<f64> {
    let along = way.normalize();
    let axes = [Some(joint), next].into_iter().flatten().filter_map(|j| {
        at.chain().joint_motion(j).map(|motion| at.frame(motion.frame).rotation * motion.axis)
    });
    let own = at.frame(at.chain().frame_after(joint)).rotation;
    let any = (0..3).map(|k| own.column(k).into_owned());
    // One of three perpendicular axes is always far from the link's.
    axes.chain(any)
        .map(|axis| axis - along * along.dot(&axis))
        .find(|square| square.norm() > 0.3)
        .map_or(along, |square| square.normalize())
}

#[cfg(test)]
mod tests;
