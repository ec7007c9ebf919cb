//! A linear axis whose rail is not straight: the carriage is displaced and turned as it travels.
//!
//! `ε_j(q) = Σ_k c_k (B_k(q) − B_k(q̄))`, k = 2 … N: cubic B-splines over the travel without their constant, zero in the
//! middle q̄ of it. It acts on the frame after the slide, which is fixed to the carriage in every convention: `x y z` are
//! in the axes of that frame (straightness; along the axis, positioning), `rx ry rz` turn about its origin (pitch, yaw,
//! roll).
//!
//! With `by_load` the rail gives way under what it carries, by another amount at each place (a bridge between its posts): `t = C(q) F`, `φ = R(q)
//! (a × F)`, F the force across the axis a, C and R such splines with their constant, m/N and rad/N.
//!
//! A screw of lead P adds `c_s sin(2πq/P) + c_c cos(2πq/P)` along the axis; the lead is its shape where `screw_range` is
//! given. Source: Slocum, *Precision Machine Design*, section 2.3.

use super::checks::{joint_moves, refused};
use super::expansion::Basis;
use super::robot_size::robot_size;
use super::spot::distinct;
use super::travel::{ascending, free, positive, travel};
use crate::lanes::{LANES, LaneEmission, LanePosture};
use crate::{Column, Effect, Emission, ModelError, NonlinearParameter, Search};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use truepose_kinematics::{Axis, Chain, JointId, JointKind, Posture, Site};

/// Smooth errors of a slide over its travel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Guideway {
    /// The slide.
    pub joint: JointId,
    /// Which components of the frame after it; all six when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub components: Option<Vec<Axis>>,
    /// The travel, m; the joint's limits when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Equal pieces into which the travel is cut.
    #[serde(default = "six")]
    pub pieces: usize,
    /// Lead of the screw, m; no screw when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub screw: Option<f64>,
    /// Between which leads `screw` is to be found, m; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub screw_range: Option<[f64; 2]>,
    /// Whether it gives way under its load, in place of an error of its own.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub by_load: bool,
}

fn six() -> usize {
    6
}

impl Guideway {
    /// Of one slide, all six components over its limits.
    pub fn of(joint: JointId) -> Self {
        Guideway {
            joint,
            components: None,
            range: None,
            pieces: six(),
            screw: None,
            screw_range: None,
            by_load: false,
        }
    }

    /// A rail that gives way under its load, over this travel (m) in so many pieces.
    pub fn sagging(joint: JointId, range: [f64; 2], pieces: usize) -> Self {
        Guideway { by_load: true, range: Some(range), pieces, ..Guideway::of(joint) }
    }

    /// Emits how the rail gives way at the carriage.
    fn sag(&self, at: &Posture<'_>, out: &mut Emission) {
        let (q, frame) = (at.joint(self.joint), at.chain().frame_after(self.joint));
        let axis = at.chain().joint(self.joint).axis_behind();
        let force = at.wrench(frame).force;
        let (across, turn) = (force - axis * axis.dot(&force), axis.cross(&force));
        let basis = self.basis(at.chain());
        let count = basis.len();
        basis.for_each(q, |column, value| {
            for part in Axis::ALL {
                let (column, vector) =
                    if part.is_rotation() { (count + column, &turn) } else { (column, &across) };
                out.push(column, Site::Frame(frame, part), value * vector[part.direction()]);
            }
        });
    }

    fn basis(&self, chain: &Chain) -> Basis {
        let [lower, upper] = travel(self.range, self.joint, chain);
        Basis::Spline { lower, upper, pieces: self.pieces, degree: 3 }
    }

    fn components(&self) -> &[Axis] {
        self.components.as_deref().unwrap_or(&Axis::ALL)
    }
}

impl Effect for Guideway {
    const FAMILY: &'static str = "guideway";
    const ABOUT: &'static str = "straightness, positioning, pitch, yaw and roll of a slide over its travel; its sag under the load (by_load)";

    fn load_dependent(&self) -> bool {
        self.by_load
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let frame = chain.frame_after(self.joint);
        let mut columns = Vec::new();
        if self.by_load {
            // A kilonewton: 0.05 mm and 0.05 mrad.
            let name = &chain.joint(self.joint).name;
            for (what, unit, scale) in [("sag", "m/N", 5e-8 * robot_size(chain)), ("slope", "rad/N", 5e-8)] {
                let one = |k| Column::new(format!("{what} {name} B{k}"), unit, scale);
                columns.extend((1..=self.basis(chain).len()).map(one));
            }
            return columns;
        }
        for &axis in self.components() {
            for k in 2..=self.basis(chain).len() {
                let name = format!("guideway {} B{k}", chain.site_word(Site::Frame(frame, axis)));
                // A good rail: 0.05 mm and 0.05 mrad over its travel.
                let length = if axis.is_rotation() { 1.0 } else { robot_size(chain) };
                columns.push(Column::new(name, axis.unit(), 5e-5 * length));
            }
        }
        if self.screw.is_some() {
            let name = &chain.joint(self.joint).name;
            columns.push(Column::new(format!("screw {name} sin"), "m", 2e-5 * robot_size(chain)));
            columns.push(Column::new(format!("screw {name} cos"), "m", 2e-5 * robot_size(chain)));
        }
        columns
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        if self.by_load {
            return self.sag(at, out);
        }
        let (q, frame) = (at.joint(self.joint), at.chain().frame_after(self.joint));
        let [lower, upper] = travel(self.range, self.joint, at.chain());
        let basis = self.basis(at.chain());
        let width = basis.len() - 1;
        basis.for_each_from(0.5 * (lower + upper), q, |column, value| {
            for (k, &axis) in self.components().iter().enumerate() {
                out.push(k * width + column, Site::Frame(frame, axis), value);
            }
        });
        if let (Some(lead), Some(motion)) = (self.screw, at.chain().joint_motion(self.joint)) {
            let first = self.components().len() * width;
            let (s, c) = (TAU * q / lead).sin_cos();
            out.along(first, &motion, s);
            out.along(first + 1, &motion, c);
        }
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        if self.by_load {
            return false;
        }
        let Some(joint) = at.joint(self.joint) else { return false };
        let joint = &joint[..at.rows()];
        let (chain, frame) = (at.chain(), at.chain().frame_after(self.joint));
        let [lower, upper] = travel(self.range, self.joint, chain);
        let basis = self.basis(chain);
        let width = basis.len() - 1;
        let values = out.values(width, |into| {
            for (lane, &q) in joint.iter().enumerate() {
                basis.for_each_from(0.5 * (lower + upper), q, |column, value| {
                    into[column * LANES + lane] += value;
                });
            }
        });
        for (column, value) in values.enumerate() {
            for (k, &axis) in self.components().iter().enumerate() {
                out.push(k * width + column, Site::Frame(frame, axis), value);
            }
        }
        if let (Some(lead), Some(motion)) = (self.screw, chain.joint_motion(self.joint)) {
            let first = self.components().len() * width;
            for (k, wave) in [f64::sin, f64::cos].into_iter().enumerate() {
                let value = out.value(|into| {
                    into.iter_mut().zip(joint).for_each(|(into, q)| *into = wave(TAU * q / lead));
                });
                out.along(first + k, &motion, value);
            }
        }
        true
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        joint_moves(Self::FAMILY, self.joint, chain)?;
        if chain.joint(self.joint).kind != JointKind::Prismatic {
            let name = &chain.joint(self.joint).name;
            return Err(refused(
                Self::FAMILY,
                format!("joint `{name}` turns; a guideway belongs to a slide"),
            ));
        }
        if let Some(list) = &self.components {
            distinct(Self::FAMILY, list)?;
        }
        ascending(Self::FAMILY, "range", self.range)?;
        if self.by_load && (self.components.is_some() || self.screw.is_some()) {
            return Err(refused(Self::FAMILY, "`components` and `screw` do not belong to `by_load`"));
        }
        match self.screw {
            Some(lead) => positive(Self::FAMILY, "screw", lead, self.screw_range)?,
            None if self.screw_range.is_some() => {
                return Err(refused(Self::FAMILY, "`screw_range` stands without `screw`"));
            }
            None => {}
        }
        self.basis(chain).check().map_err(|reason| refused(Self::FAMILY, reason))
    }

    fn shape(&self) -> Vec<NonlinearParameter> {
        let search = Search::Period(self.joint, 1);
        self.screw.map_or_else(Vec::new, |lead| free("screw", "m", lead, self.screw_range, search))
    }

    fn with_nonlinear(&self, values: &[f64]) -> Self {
        Guideway { screw: values.first().copied().or(self.screw), ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::{Conditions, Load, Payload, samples};

    #[test]
    fn conforms_on_every_slide() {
        for chain in samples::all() {
            for &joint in chain.movable().iter().filter(|&&j| chain.joint(j).kind == JointKind::Prismatic) {
                check_effect(&Guideway::of(joint), &chain);
                check_effect(&Guideway::sagging(joint, [-0.5, 0.7], 2), &chain);
                let components = Some(vec![Axis::Ty, Axis::Rz]);
                let (screw, screw_range) = (Some(0.01), Some([0.005, 0.02]));
                let effect = Guideway { components, screw, screw_range, ..Guideway::of(joint) };
                check_effect(&effect, &chain);
            }
        }
    }

    #[test]
    fn it_is_zero_in_the_middle_of_the_travel() {
        let chain = samples::pps();
        let effect = Guideway { components: Some(vec![Axis::Rz]), ..Guideway::of(JointId(3)) };
        let at = |d3: f64| {
            let conditions = Conditions::at(&chain, &[0.0, 0.0, d3, 0.0, 0.0, 0.0]);
            let entries = emitted(&effect, &chain, &conditions);
            (0..8).map(|k| entries.iter().filter(|e| e.column == k).map(|e| e.value).sum::<f64>()).collect()
        };
        let (middle, end): (Vec<f64>, Vec<f64>) = (at(-0.435), at(0.3));
        assert!(middle.iter().all(|v| v.abs() < 1e-15), "{middle:?}");
        assert!(end.iter().any(|v| v.abs() > 0.1), "{end:?}");
    }

    #[test]
    fn a_rail_gives_way_across_its_axis_in_proportion_to_what_it_carries() {
        let chain = samples::pps();
        let (joint, frame) = (JointId(1), chain.frame_after(JointId(1)));
        let effect = Guideway::sagging(joint, [0.0, 2.0], 1);
        let at = |mass: f64| {
            let load = Load::Payload(Payload { mass, com: [0.0; 3].into() });
            Conditions::at(&chain, &[0.8, 0.1, 0.2, 0.0, 0.0, 0.0]).with_load(load)
        };
        // All coefficients one: the basis adds up to one.
        let moved = |mass: f64, first: usize| -> [f64; 3] {
            let all = emitted(&effect, &chain, &at(mass));
            [0, 1, 2].map(|k| {
                let site = Site::Frame(frame, Axis::ALL[first + k]);
                all.iter().filter(|e| e.site == site).map(|e| e.value).sum()
            })
        };
        let (more, less) = (moved(60.0, 0), moved(10.0, 0));
        let grown: f64 = more.iter().zip(less).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        // 50 kg more hang across a level rail.
        assert!((grown - 50.0 * 9.81).abs() < 0.01 * grown, "{grown}");
        assert!(moved(60.0, 3).iter().any(|v| v.abs() > 100.0));
        let both = Guideway { screw: Some(0.01), ..effect };
        assert!(Effect::validate(&both, &chain).unwrap_err().to_string().contains("`by_load`"));
    }

    #[test]
    fn a_turn_has_no_guideway() {
        let error = Effect::validate(&Guideway::of(JointId(4)), &samples::pps()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "effect `guideway`: joint `theta` turns; a guideway belongs to a slide"
        );
    }
}
