//! Ways in which a joint yields besides "at once, about its axis, in proportion to the load".
//!
//! ```text
//! bearing       w = C m                     rotation w across the axis by the moment m across it; C symmetric 2 × 2 in the axes of the link behind
//! creep         δq_j = c τ̃_j                τ̃_j follows the load late, lag · dτ̃/dt = τ_j − τ̃: a part of the deflection that comes late
//! temperature   δq_j = c (T − T_ref) τ_j    the stiffness changes with the temperature
//! counterbalance δq_j = k_1 sin x + k_2 sin x / √(1 + s cos x),   x = q_j − φ     the torque of a counterbalance that nobody declared
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | C | three unknowns: two directions across the axis, and between them; of a slide a fourth, roll about it | rad/(N·m) |
//! | c | one unknown a joint | rad/(N·m), rad/(N·m·K); m/N, m/(N·K) |
//! | τ̃_j | a derived channel ([`crate::History::Load`]), `tau_3~lag=600` | N·m or N |
//!
//! A spring between a point of the link in front, a from the axis, and one of the link behind, b from it, has the length √(a² + b²) √(1 + s cos x), s =
//! 2ab/(a² + b²) (`ratio`), and φ (`offset`) is where it is longest; k_1 is its stiffness, k_2 its free length, both times the joint's compliance, rad.
//!
//! The bearing tilts about the point of the axis that the description has for it; a slide about the origin of its carriage. What yields at once is the plain
//! `joint_compliance`, beside which these stand. Sources: Harris and Kotzalas, *Rolling Bearing Analysis* (moment load); Zener's anelastic solid.

use super::JointCompliance;
use crate::effects::checks::refused;
use crate::effects::free_weight::across;
use crate::effects::link_compliance::OwnWeight;
use crate::effects::robot_size::robot_size;
use crate::effects::travel::{ascending, positive};
use crate::{Column, Effect, Emission, History, ModelError, history_channel};
use serde::{Deserialize, Serialize};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Axis, Chain, JointId, JointKind, Posture, Site};

/// How a joint yields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ComplianceMode {
    /// About or along its axis, at once.
    #[default]
    Axis,
    /// Across its axis: the bearing tilts.
    Bearing,
    /// About or along its axis, late.
    Creep,
    /// About or along its axis, in proportion to a temperature as well.
    Temperature,
    /// About its axis, under the torque of a spring.
    Counterbalance,
}

impl ComplianceMode {
    pub(in crate::effects) fn is_axis(&self) -> bool {
        *self == ComplianceMode::Axis
    }
}

/// Twenty kelvin change a stiffness by a fifth.
const PER_KELVIN: f64 = 1e-2;
/// A bearing is ten times as stiff across its axis as its drive is about it.
const TILT: f64 = 1e-6;

impl JointCompliance {
    /// A bearing that tilts.
    pub fn bearing(joint: JointId) -> Self {
        JointCompliance { mode: ComplianceMode::Bearing, ..JointCompliance::of(joint) }
    }

    /// A part of the deflection that comes late, with this time constant, s.
    pub fn creep(joint: JointId, lag: f64) -> Self {
        JointCompliance { mode: ComplianceMode::Creep, lag: Some(lag), ..JointCompliance::of(joint) }
    }

    /// A stiffness that changes with a temperature, nominal at `reference` (in the channel's unit).
    pub fn by_temperature(joint: JointId, channel: impl Into<String>, reference: f64) -> Self {
        let channel = Some(channel.into());
        let mode = ComplianceMode::Temperature;
        JointCompliance { mode, channel, reference: Some(reference), ..JointCompliance::of(joint) }
    }

    /// A spring that is longest at this angle (rad), with 2ab/(a² + b²) of its levers.
    pub fn counterbalance(joint: JointId, offset: f64, ratio: f64) -> Self {
        let mode = ComplianceMode::Counterbalance;
        JointCompliance { mode, offset: Some(offset), ratio: Some(ratio), ..JointCompliance::of(joint) }
    }

    /// The columns of a mode other than `axis`, of one joint.
    pub(super) fn columns_of_mode(&self, chain: &Chain, id: JointId, columns: &mut Vec<Column>) {
        let joint = chain.joint(id);
        let (name, slides) = (&joint.name, joint.kind == JointKind::Prismatic);
        let size = robot_size(chain);
        let (unit, scale) = if slides { ("m/N", 1e-7 * size) } else { ("rad/(N*m)", 1e-5 / size) };
        match self.mode {
            ComplianceMode::Axis => {}
            ComplianceMode::Creep => {
                let creep = Column::new(format!("creep {name}"), unit, 0.2 * scale);
                columns.push(creep.within(0.0, f64::INFINITY));
            }
            ComplianceMode::Temperature => {
                let unit = if slides { "m/(N*K)" } else { "rad/(N*m*K)" };
                columns.push(Column::new(
                    format!("compliance {name} by temperature"),
                    unit,
                    PER_KELVIN * scale,
                ));
            }
            ComplianceMode::Counterbalance => {
                // A tenth of a milliradian: 10 µrad/(N·m) under a tenth of what is balanced.
                let column =
                    |what: &str| Column::new(format!("counterbalance {name} {what}"), joint.unit(), 1e-4);
                columns.extend(["stiffness", "free length"].map(column));
            }
            ComplianceMode::Bearing => {
                let mut put = |what: &str, lower: f64| {
                    let tilt = Column::new(format!("bearing {name} {what}"), "rad/(N*m)", TILT / size);
                    columns.push(tilt.within(lower, f64::INFINITY));
                };
                put("11", 0.0);
                put("22", 0.0);
                put("12", f64::NEG_INFINITY);
                if slides {
                    put("roll", 0.0);
                }
            }
        }
    }

    /// Refuses keys of other modes, and modes without their keys.
    pub(super) fn validate_mode(&self, chain: &Chain) -> Result<(), ModelError> {
        let refuse = |reason: &str| Err(refused(JointCompliance::FAMILY, reason));
        if self.mode != ComplianceMode::Creep && (self.lag.is_some() || self.lag_range.is_some()) {
            return refuse("`lag` and `lag_range` belong to the mode `creep`");
        }
        if self.mode != ComplianceMode::Temperature && self.reference.is_some() {
            return refuse("`reference` belongs to the mode `temperature`");
        }
        if !self.mode.is_axis() && self.own_weight != OwnWeight::Declared {
            return refuse("`own_weight` belongs to the mode `axis`");
        }
        if self.mode == ComplianceMode::Counterbalance {
            self.validate_spring(chain)?;
        } else if self.offset.is_some()
            || self.offset_range.is_some()
            || self.ratio.is_some()
            || self.ratio_range.is_some()
        {
            return refuse("`offset` and `ratio` belong to the mode `counterbalance`");
        }
        match self.mode {
            ComplianceMode::Creep => match self.lag {
                None => return refuse("the mode `creep` needs `lag`, a time constant in s"),
                Some(_) if self.joints.is_none() => return refuse("the mode `creep` needs `joints`"),
                Some(lag) => positive(JointCompliance::FAMILY, "lag", lag, self.lag_range)?,
            },
            ComplianceMode::Temperature if self.channel.is_none() => {
                return refuse("the mode `temperature` needs `channel`, a thermometer");
            }
            ComplianceMode::Temperature if self.reference.is_some_and(|at| !at.is_finite()) => {
                return refuse("`reference` has to be finite");
            }
            _ => {}
        }
        if self.channel.is_some()
            && matches!(
                self.mode,
                ComplianceMode::Bearing | ComplianceMode::Creep | ComplianceMode::Counterbalance
            )
        {
            return refuse("`channel` belongs to the modes `axis` and `temperature`");
        }
        Ok(())
    }

    fn validate_spring(&self, chain: &Chain) -> Result<(), ModelError> {
        let refuse = |reason: &str| Err(refused(JointCompliance::FAMILY, reason));
        if self.joints(chain).iter().any(|&joint| chain.joint(joint).kind != JointKind::Revolute) {
            return refuse("the mode `counterbalance` is of a joint that turns");
        }
        if self.ratio.is_some_and(|ratio| !(0.0..1.0).contains(&ratio)) {
            return refuse("`ratio` lies between 0 and 1");
        }
        if self.offset.is_some_and(|offset| !offset.is_finite()) {
            return refuse("`offset` has to be finite");
        }
        ascending(JointCompliance::FAMILY, "offset_range", self.offset_range)?;
        ascending(JointCompliance::FAMILY, "ratio_range", self.ratio_range)
    }

    /// How many unknowns a joint has in such a mode.
    fn count(&self, chain: &Chain, joint: JointId) -> usize {
        match (self.mode, chain.joint(joint).kind) {
            (ComplianceMode::Bearing, JointKind::Prismatic) => 4,
            (ComplianceMode::Bearing, _) => 3,
            (ComplianceMode::Counterbalance, _) => 2,
            _ => 1,
        }
    }

    /// Emits a mode other than `axis`.
    pub(super) fn eval_mode(&self, at: &Posture<'_>, out: &mut Emission) {
        let chain = at.chain();
        let mut column = 0;
        for (k, &joint) in self.joints(chain).iter().enumerate() {
            let Some(motion) = chain.joint_motion(joint) else { continue };
            match self.mode {
                ComplianceMode::Axis => {}
                ComplianceMode::Creep => out.along(column, &motion, at.signal(k)),
                ComplianceMode::Temperature => {
                    let warmer = at.signal(0) - self.reference.unwrap_or(ROOM);
                    out.along(column, &motion, warmer * at.joint_load(joint));
                }
                ComplianceMode::Bearing => tilt(joint, column, at, out),
                ComplianceMode::Counterbalance => {
                    let (sine, cosine) = (at.joint(joint) - self.offset.unwrap_or(0.0)).sin_cos();
                    out.along(column, &motion, sine);
                    let length = (1.0 + self.ratio.unwrap_or(HALF) * cosine).sqrt();
                    out.along(column + 1, &motion, sine / length);
                }
            }
            column += self.count(chain, joint);
        }
    }

    /// The channels of such a mode.
    pub(super) fn channels_of_mode(&self) -> Vec<String> {
        match (self.mode, self.lag) {
            (ComplianceMode::Creep, Some(lag)) => {
                let one = |&joint: &JointId| history_channel(History::Load(joint), lag);
                self.joints.iter().flatten().map(one).collect()
            }
            _ => self.channel.iter().cloned().collect(),
        }
    }
}

/// Levers of a spring of which one is about twice the other.
const HALF: f64 = 0.8;
/// Where a stiffness is as declared when nothing else is said, degC.
const ROOM: f64 = 20.0;

/// A bearing tilts across its axis: unit compliances in two directions of the link behind, and between them.
fn tilt(joint: JointId, column: usize, at: &Posture<'_>, out: &mut Emission) {
    let chain = at.chain();
    let Some(motion) = chain.joint_motion(joint) else { return };
    let behind = chain.frame_after(joint);
    let slides = motion.kind == JointKind::Prismatic;
    let frame = if slides { behind } else { motion.frame };
    let (home, link) = (at.frame(frame), at.frame(behind));
    let arm = link.translation - home.translation;
    let moment = at.wrench(behind).rotated(&link.rotation).carried_to(&arm).moment;
    let [first, second] = across(chain.joint(joint)).map(|direction| link.rotation * direction);
    let (by_first, by_second) = (first.dot(&moment), second.dot(&moment));
    let mut put = |column: usize, turn: Vector3<f64>| {
        let turn = home.rotation.tr_mul(&turn);
        for axis in Axis::ALL.into_iter().filter(|axis| axis.is_rotation()) {
            out.push(column, Site::Frame(frame, axis), turn[axis.direction()]);
        }
    };
    put(column, first * by_first);
    put(column + 1, second * by_second);
    put(column + 2, first * by_second + second * by_first);
    if slides {
        let roll = link.rotation * chain.joint(joint).axis_behind();
        put(column + 3, roll * roll.dot(&moment));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Signal;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::{Conditions, Load, Payload, samples};

    #[test]
    fn conforms() {
        for chain in samples::all() {
            let all = Some(chain.movable().to_vec());
            for &joint in chain.movable() {
                check_effect(&JointCompliance::bearing(joint), &chain);
            }
            check_effect(
                &JointCompliance { joints: all.clone(), ..JointCompliance::bearing(JointId(1)) },
                &chain,
            );
            let late = JointCompliance { joints: all.clone(), ..JointCompliance::creep(JointId(1), 600.0) };
            check_effect(&JointCompliance { lag_range: Some([60.0, 6000.0]), ..late }, &chain);
            let warm = JointCompliance::by_temperature(JointId(1), "oil", 22.0);
            check_effect(&JointCompliance { joints: all, ..warm }, &chain);
        }
    }

    #[test]
    fn a_spring_turns_its_joint_by_its_lever() {
        let chain = samples::ur10();
        let spring = JointCompliance::counterbalance(JointId(2), 0.4, 0.7);
        let (offset_range, ratio_range) = (Some([-1.0, 1.0]), Some([0.1, 0.95]));
        check_effect(&JointCompliance { offset_range, ratio_range, ..spring.clone() }, &chain);
        check_effect(&JointCompliance { ratio_range, ..spring.clone() }, &chain);
        // Levers a and b with 2ab/(a² + b²) = 0.7, by the length of the spring.
        let (a, b) = (1.0f64, (1.0 - (1.0 - 0.49f64).sqrt()) / 0.7);
        let length = |x: f64| (a * a + b * b + 2.0 * a * b * x.cos()).sqrt();
        for q in [-1.3, 0.2, 0.9] {
            let at = Conditions::at(&chain, &[0.0, q, 0.0, 0.0, 0.0, 0.0]);
            let all = emitted(&spring, &chain, &at);
            let value = |k: usize| all.iter().filter(|e| e.column == k).map(|e| e.value).sum::<f64>();
            let (stiffness, free) = (3.0, 0.5);
            let energy = |x: f64| 0.5 * stiffness * (length(x) - free).powi(2);
            let (x, step) = (q - 0.4, 1e-6);
            let torque = -(energy(x + step) - energy(x - step)) / (2.0 * step);
            let scale = (a * a + b * b).sqrt();
            let expected = stiffness * a * b * value(0) - stiffness * free * a * b / scale * value(1);
            assert!((torque - expected).abs() < 1e-8, "{q}: {torque} {expected}");
        }
        let slide = JointCompliance::counterbalance(samples::pps().movable()[0], 0.4, 0.7);
        assert!(Effect::validate(&slide, &samples::pps()).unwrap_err().to_string().contains("turns"));
    }

    /// Rotation of a bearing in the measurement frame per unit of a column.
    fn turned(effect: &JointCompliance, chain: &Chain, at: &Conditions, column: usize) -> Vector3<f64> {
        let mut buffer = truepose_kinematics::PostureBuffer::new(chain);
        let posture = buffer.update(chain, at);
        let mut sum = Vector3::zeros();
        for e in emitted(effect, chain, at).iter().filter(|e| e.column == column) {
            let Site::Frame(frame, axis) = e.site else { panic!("{:?}", e.site) };
            sum += posture.frame(frame).rotation.column(axis.direction()) * e.value;
        }
        sum
    }

    #[test]
    fn a_bearing_turns_by_the_moment_across_its_axis_in_every_convention() {
        // A weight on the tool: the moment about the shoulder is lever × weight, about whatever axes.
        for chain in [samples::ur10(), samples::heavy()] {
            let joint = JointId(1);
            let q = [0.7, -0.4, 0.5, 0.3, -0.2, 0.1];
            let load = Load::Payload(Payload { mass: 10.0, com: Vector3::zeros() });
            let (loaded, empty) = (Conditions::at(&chain, &q).with_load(load), Conditions::at(&chain, &q));
            let effect = JointCompliance::bearing(joint);
            let turn =
                |column| turned(&effect, &chain, &loaded, column) - turned(&effect, &chain, &empty, column);
            let mut buffer = truepose_kinematics::PostureBuffer::new(&chain);
            let posture = buffer.update(&chain, &loaded);
            let motion = chain.joint_motion(joint).expect("it turns");
            let home = posture.frame(motion.frame);
            let axis = home.rotation * motion.axis;
            let lever = posture.tool().translation - home.translation;
            let moment = lever.cross(&(chain.gravity_in_measurement_frame() * 10.0));
            let across = moment - axis * axis.dot(&moment);
            // As compliant in both directions: along the moment.
            let both = turn(0) + turn(1);
            assert!((both - across).norm() < 1e-9 * across.norm(), "{}: {both} {across}", chain.name());
            assert!(turn(2).norm() > 0.0 && turn(2).dot(&axis).abs() < 1e-9);
        }
    }

    #[test]
    fn creep_reads_the_late_load_and_a_warm_joint_its_load_and_temperature() {
        let chain = samples::ur10();
        let creep = JointCompliance::creep(JointId(2), 600.0);
        assert_eq!(Effect::needs(&creep), [Signal::Channel("tau_2~lag=600".into())]);
        let mut at = Conditions::at(&chain, &[0.3; 6]);
        at.channels = vec![-40.0];
        let sum = |effect: &JointCompliance, at: &Conditions| -> f64 {
            emitted(effect, &chain, at).iter().map(|e| e.value).sum()
        };
        assert!((sum(&creep, &at) + 40.0).abs() < 1e-12);
        let mut warm = at.with_load(Load::Payload(Payload { mass: 5.0, com: Vector3::zeros() }));
        warm.channels = vec![27.0];
        let effect = JointCompliance::by_temperature(JointId(2), "oil", 22.0);
        let plain = sum(&JointCompliance::of(JointId(2)), &warm);
        assert!((sum(&effect, &warm) - 5.0 * plain).abs() < 1e-9 * plain.abs() && plain != 0.0);
        let refused = |effect: JointCompliance| Effect::validate(&effect, &chain).unwrap_err().to_string();
        assert!(refused(JointCompliance { lag: None, ..creep.clone() }).contains("needs `lag`"));
        assert!(refused(JointCompliance { joints: None, ..creep.clone() }).contains("`joints`"));
        assert!(refused(JointCompliance { mode: ComplianceMode::Bearing, ..creep }).contains("`lag`"));
        assert!(refused(JointCompliance { channel: None, ..effect }).contains("needs `channel`"));
    }
}
