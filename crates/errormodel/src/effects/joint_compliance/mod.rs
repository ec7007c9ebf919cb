//! A joint that yields in proportion to the load about (or along) its axis.
//!
//! `δq_j = c_j τ_j`, τ_j the load that the weights exert about joint j's axis, N·m (along it, N, for a slide);
//! c_j > 0 in rad/(N·m) or m/N.
//!
//! Weights of links that nobody declared are left out of τ_j. With `own_weight = "free"` they are unknowns beside c_j:
//!
//! ```text
//! δq_j = c_j τ_j + Σ_k (c_j h_k) · (g × a_j)_k        links k = j and the next `links − 1` ones
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | a_j, g | axis of joint j, gravity | 1, m/s² | turned into link k |
//! | c_j h_k | the unknowns: compliance × first moment of link k | rad·kg·m/(N·m) | link k, across its axis |
//!
//! A joint whose torque is measured (by its motor's current, or a sensor) yields with that: `δq_j = c_j u`, u the channel in its unit. Its
//! sign is the sensor's: c_j may be negative.
//!
//! The part of h_k along axis k does not turn with joint k: it belongs to the link in front, so that two numbers a turning
//! link are all there is. A slide k has `q_k (a_k × g)` with its mass, and a slide j that yields, `a_j · g`.

mod mode;

pub use mode::ComplianceMode;

use crate::effects::checks::{joint_moves, listed_once, refused};
use crate::effects::free_weight::across;
use crate::effects::geometric::EXPECTED_ANGLE;
use crate::effects::link_compliance::OwnWeight;
use crate::effects::robot_size::robot_size;
use crate::effects::travel::free;
use crate::lanes::{LaneEmission, LanePosture};
use crate::{Column, Effect, Emission, ModelError, NonlinearParameter, Search, Signal};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Chain, JointId, JointKind, Posture};

/// Compliance of joints, one unknown each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointCompliance {
    /// Which joints; all that move when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<Vec<JointId>>,
    /// Where the weight of the links comes from.
    #[serde(default, skip_serializing_if = "OwnWeight::is_declared")]
    pub own_weight: OwnWeight,
    /// How many links, the joint's own first, have a free weight.
    #[serde(default = "two", skip_serializing_if = "is_two")]
    pub links: usize,
    /// The channel that is the load of the joint, in place of the statics; `joints` names the one joint. Of the mode `temperature` the thermometer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
    /// How it yields.
    #[serde(default, skip_serializing_if = "ComplianceMode::is_axis")]
    pub mode: ComplianceMode,
    /// Of the mode `creep`: the time constant with which the joint follows its load, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag: Option<f64>,
    /// Between which time constants `lag` is to be found, s; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag_range: Option<[f64; 2]>,
    /// Of the mode `temperature`: where the stiffness is as declared, in the channel's unit; 20 when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<f64>,
    /// Of the mode `counterbalance`: the angle at which it is longest, rad; zero when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<f64>,
    /// Between which angles `offset` is to be found, rad; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_range: Option<[f64; 2]>,
    /// Of the mode `counterbalance`: 2ab/(a² + b²) of its levers, between 0 and 1; 0.8 when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratio: Option<f64>,
    /// Between which values `ratio` is to be found; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratio_range: Option<[f64; 2]>,
}

fn two() -> usize {
    2
}

fn is_two(links: &usize) -> bool {
    *links == two()
}

impl Default for JointCompliance {
    fn default() -> Self {
        JointCompliance {
            joints: None,
            own_weight: OwnWeight::Declared,
            links: two(),
            channel: None,
            mode: ComplianceMode::Axis,
            lag: None,
            lag_range: None,
            reference: None,
            offset: None,
            offset_range: None,
            ratio: None,
            ratio_range: None,
        }
    }
}

impl JointCompliance {
    /// Of one joint.
    pub fn of(joint: JointId) -> Self {
        JointCompliance { joints: Some(vec![joint]), ..JointCompliance::default() }
    }

    /// Of one joint, whose load is a channel.
    pub fn measured(joint: JointId, channel: impl Into<String>) -> Self {
        JointCompliance { channel: Some(channel.into()), ..JointCompliance::of(joint) }
    }

    fn joints<'a>(&'a self, chain: &'a Chain) -> &'a [JointId] {
        self.joints.as_deref().unwrap_or_else(|| chain.movable())
    }

    /// The moving joints whose links have a free weight that bends this joint, and how many numbers each has.
    fn free<'a>(&self, joint: JointId, chain: &'a Chain) -> impl Iterator<Item = (JointId, usize)> + use<'a> {
        let slides = chain.joint(joint).kind == JointKind::Prismatic;
        let count = match self.own_weight {
            OwnWeight::Declared => 0,
            OwnWeight::Free if slides => 1,
            OwnWeight::Free => self.links,
        };
        let from = chain.movable().iter().copied().filter(move |&k| k >= joint).take(count);
        from.map(|k| (k, if chain.joint(k).kind == JointKind::Prismatic { 1 } else { 2 }))
    }
}

impl Effect for JointCompliance {
    const FAMILY: &'static str = "joint_compliance";
    const ABOUT: &'static str = "a joint yields in proportion to the load about (along) its axis or to its measured torque; across its axis (bearing), late (creep), by temperature (mode)";

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let mut columns = Vec::new();
        for &id in self.joints(chain) {
            let joint = chain.joint(id);
            if !self.mode.is_axis() {
                self.columns_of_mode(chain, id, &mut columns);
                continue;
            }
            if let Some(channel) = &self.channel {
                // As where the load is in N·m; a torque in per cent of some hundred N·m has the same.
                let unit = format!("{}/[{channel}]", joint.unit());
                let scale = if joint.kind == JointKind::Prismatic { 1e-7 * robot_size(chain) } else { 1e-5 };
                columns.push(Column::new(format!("compliance {}", joint.name), unit, scale));
                continue;
            }
            let (unit, scale) = match joint.kind {
                JointKind::Prismatic => ("m/N", 1e-7 * robot_size(chain)),
                _ => ("rad/(N*m)", 1e-5 / robot_size(chain)),
            };
            let yields = Column::new(format!("compliance {}", joint.name), unit, scale);
            columns.push(yields.within(0.0, f64::INFINITY));
            for (k, numbers) in self.free(id, chain) {
                let (unit, scale) = match (joint.kind, numbers) {
                    (JointKind::Prismatic, _) => ("kg*m/N", 1e-5 * robot_size(chain)),
                    (_, 1) => ("rad*kg/(N*m)", EXPECTED_ANGLE / 9.81 / robot_size(chain)),
                    _ => ("rad*kg*m/(N*m)", EXPECTED_ANGLE / 9.81),
                };
                for number in 1..=numbers {
                    let name = format!("weight of {} on {} {number}", chain.joint(k).name, joint.name);
                    columns.push(Column::new(name, unit, scale));
                }
            }
        }
        columns
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        if !self.mode.is_axis() {
            return self.eval_mode(at, out);
        }
        let (chain, mut column) = (at.chain(), 0);
        let gravity = chain.gravity_in_measurement_frame();
        for &joint in self.joints(chain) {
            let Some(motion) = chain.joint_motion(joint) else { continue };
            if self.channel.is_some() {
                return out.along(0, &motion, at.signal(0));
            }
            out.along(column, &motion, at.joint_load(joint));
            column += 1;
            if self.own_weight == OwnWeight::Declared {
                continue;
            }
            let axis = at.frame(motion.frame).rotation * motion.axis;
            for (k, numbers) in self.free(joint, chain) {
                let (link, rotation) = (chain.joint(k), &at.frame(chain.frame_after(k)).rotation);
                let loads = match (motion.kind, link.kind) {
                    (JointKind::Prismatic, _) => [axis.dot(&gravity), 0.0],
                    (_, JointKind::Prismatic) => {
                        let moved = rotation * link.axis_behind() * at.joint(k);
                        [axis.dot(&moved.cross(&gravity)), 0.0]
                    }
                    _ => across(link).map(|arm| axis.dot(&(rotation * arm).cross(&gravity))),
                };
                for &load in &loads[..numbers] {
                    out.along(column, &motion, load);
                    column += 1;
                }
            }
        }
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        if self.own_weight != OwnWeight::Declared || self.channel.is_some() || !self.mode.is_axis() {
            return false;
        }
        let chain = at.chain();
        let motions = self.joints(chain).iter().filter_map(|&joint| chain.joint_motion(joint));
        for (column, motion) in motions.enumerate() {
            let load = out.value(|into| into.copy_from_slice(at.joint_load(motion.joint)));
            out.along(column, &motion, load);
        }
        true
    }

    fn load_dependent(&self) -> bool {
        match self.mode {
            ComplianceMode::Axis => self.channel.is_none(),
            ComplianceMode::Creep | ComplianceMode::Counterbalance => false,
            ComplianceMode::Bearing | ComplianceMode::Temperature => true,
        }
    }

    fn needs(&self) -> Vec<Signal> {
        self.channels_of_mode().into_iter().map(Signal::Channel).collect()
    }

    fn compliances(&self, chain: &Chain) -> Option<Vec<JointId>> {
        (self.channel.is_none() && self.own_weight == OwnWeight::Declared && self.mode.is_axis())
            .then(|| self.joints(chain).to_vec())
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        for &joint in self.joints.iter().flatten() {
            joint_moves(Self::FAMILY, joint, chain)?;
        }
        if self.links == 0 {
            return Err(refused(Self::FAMILY, "`links` counts the joint's own: it is 1 or more"));
        }
        self.validate_mode(chain)?;
        if self.channel.is_some() && self.mode.is_axis() {
            if self.joints.as_ref().is_none_or(|joints| joints.len() != 1) {
                return Err(refused(
                    Self::FAMILY,
                    "`channel` is the load of one joint: `joints` has to name it alone",
                ));
            }
            if self.own_weight != OwnWeight::Declared {
                return Err(refused(Self::FAMILY, "`channel` is the whole load: leave `own_weight` out"));
            }
        }
        listed_once(Self::FAMILY, self.joints.as_deref(), chain)
    }

    fn shape(&self) -> Vec<NonlinearParameter> {
        let lag = self.lag.map(|lag| free("lag", "s", lag, self.lag_range, Search::Smooth));
        let offset = self.offset.map(|at| free("offset", "rad", at, self.offset_range, Search::Smooth));
        let ratio = self.ratio.map(|ratio| free("ratio", "1", ratio, self.ratio_range, Search::Smooth));
        lag.into_iter().chain(offset).chain(ratio).flatten().collect()
    }

    fn with_nonlinear(&self, values: &[f64]) -> Self {
        let mut values = values.iter().copied();
        // Those with a range; where none has one, all in turn.
        let ranges = [self.lag_range, self.offset_range, self.ratio_range];
        let none = ranges.iter().all(Option::is_none);
        let mut next = |k: usize, known: Option<f64>| {
            known
                .map(|known| if none || ranges[k].is_some() { values.next().unwrap_or(known) } else { known })
        };
        let (lag, offset) = (next(0, self.lag), next(1, self.offset));
        JointCompliance { lag, offset, ratio: next(2, self.ratio), ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::nalgebra::{DMatrix, DVector};
    use truepose_kinematics::{Conditions, samples};

    #[test]
    fn conforms() {
        for chain in samples::all() {
            check_effect(&JointCompliance::default(), &chain);
            check_effect(&JointCompliance::measured(chain.movable()[0], "torque"), &chain);
            for links in [1, 2, 9] {
                let own_weight = OwnWeight::Free;
                check_effect(&JointCompliance { own_weight, links, ..JointCompliance::default() }, &chain);
            }
        }
    }

    /// All that a joint of a robot without payload carries lies in the span of the free weights.
    #[test]
    fn free_weights_span_what_declared_ones_do() {
        let postures = 60;
        for (chain, joints) in
            [(samples::heavy(), 2..=6), (samples::seven(), 1..=7), (samples::skewed(), 1..=6)]
        {
            for joint in joints.map(JointId).filter(|&j| chain.joint(j).moves()) {
                let own_weight = OwnWeight::Free;
                let effect = JointCompliance { own_weight, links: 9, ..JointCompliance::of(joint) };
                let columns = Effect::columns(&effect, &chain).len();
                let mut table = DMatrix::zeros(postures, columns);
                for row in 0..postures {
                    let angle = |k: usize| ((row * (7 + 4 * k)) as f64 * 0.37 + k as f64).sin();
                    let q: Vec<f64> = (0..chain.movable().len()).map(angle).collect();
                    // The longest entry of an axis carries the whole of it.
                    for entry in emitted(&effect, &chain, &Conditions::at(&chain, &q)) {
                        let axis = chain.joint_motion(joint).map_or_else(Default::default, |m| m.axis);
                        let seen = &mut table[(row, entry.column)];
                        if entry.site.axis().direction() == axis.iamax() {
                            *seen += entry.value / axis.amax();
                        }
                    }
                }
                let (load, free) = (table.column(0).into_owned(), table.columns(1, columns - 1).into_owned());
                let fitted: DVector<f64> = &free * free.clone().svd(true, true).solve(&load, 1e-9).unwrap();
                let left = (&load - fitted).norm() / (1.0 + load.norm());
                // N·m: nothing of it is left.
                assert!(left < 1e-9, "{} {}: {left}", chain.name(), chain.joint(joint).name);
            }
        }
    }

    #[test]
    fn a_measured_torque_is_the_load_of_one_joint() {
        let chain = samples::ur10();
        let measured = JointCompliance::measured(JointId(2), "tau2");
        let mut conditions = Conditions::at(&chain, &[0.3; 6]);
        conditions.channels = vec![-40.0];
        let sum: f64 = emitted(&measured, &chain, &conditions).iter().map(|e| e.value).sum();
        assert!((sum + 40.0).abs() < 1e-12);
        let all = JointCompliance { joints: None, ..measured };
        assert!(Effect::validate(&all, &chain).unwrap_err().to_string().contains("one joint"));
    }

    #[test]
    fn a_fixed_joint_is_refused() {
        let chain = samples::skewed();
        let error = Effect::validate(&JointCompliance::of(JointId(2)), &chain).unwrap_err();
        assert_eq!(
            error.to_string(),
            "effect `joint_compliance` acts on the motion of joint `flange`, which is fixed"
        );
    }
}
