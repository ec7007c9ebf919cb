//! A joint error that depends on the joint's own motion: periodic (eccentricity, gear mesh, strain wave, a lead screw), in proportion to it
//! (scale of an encoder, gear ratio), or smooth (a cheap encoder, a cam, a cable).
//!
//! ```text
//! periodic    δq_j = Σ_h s_h sin(2πh q_j / P) + c_h cos(2πh q_j / P)
//!             with `by_load`:  (s_h + s′_h |τ_j|) sin(…) + (c_h + c′_h |τ_j|) cos(…)
//! gain        δq_j = g q_j
//! curve       δq_j = Σ_k c_k (B_k(q_j) − B_k(q̄))          k = 2 … N: cubic B-splines over the travel, zero in its middle q̄
//! ```
//!
//! With `between` all of this holds in a part of the travel only: local wear, a damaged tooth.
//!
//! rad or m; τ_j is the load about or along the axis (more teeth deflect, an eccentric gear leans); P is one turn unless given, and its shape where `period_range` is given. The constant of a gain or a curve is the joint's zero, a
//! constant error.

use super::checks::{bounded, joint_moves, refused};
use super::expansion::Basis;
use super::robot_size::robot_size;
use super::travel::{ascending, free, positive, travel, within};
use crate::lanes::{LANES, LaneEmission, LanePosture};
use crate::{Column, Effect, Emission, ModelError, NonlinearParameter, Search};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use truepose_kinematics::{Chain, JointId, JointKind, Posture};

/// Harmonics of a period of one joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Transmission {
    /// The joint.
    pub joint: JointId,
    /// Which harmonics of the period; 1 is the period itself.
    #[serde(default = "fundamental")]
    pub harmonics: Vec<u32>,
    /// The period, rad or m; one turn when absent. A slide has to say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period: Option<f64>,
    /// Between which periods `period` is to be found, rad or m; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period_range: Option<[f64; 2]>,
    /// Whether the harmonics have a part in proportion to the size of the load about or along the joint's axis.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub by_load: bool,
    /// What of the joint's motion errs.
    #[serde(default, skip_serializing_if = "TransmissionMode::is_periodic")]
    pub mode: TransmissionMode,
    /// The travel of a curve, rad or m; the joint's limits when absent, else one turn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Equal pieces into which the travel of a curve is cut; four when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pieces: Option<usize>,
    /// The part of the travel that errs, rad or m; all of it when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub between: Option<[f64; 2]>,
}

/// How the error depends on the joint's motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TransmissionMode {
    /// Harmonics of a period.
    #[default]
    Periodic,
    /// In proportion.
    Gain,
    /// A smooth curve over the travel.
    Curve,
}

impl TransmissionMode {
    fn is_periodic(&self) -> bool {
        *self == TransmissionMode::Periodic
    }
}

fn fundamental() -> Vec<u32> {
    vec![1]
}

impl Transmission {
    /// One period of one joint, rad or m.
    pub fn of(joint: JointId, period: f64) -> Self {
        Transmission { period: Some(period), ..Transmission::turning(joint, fundamental()) }
    }

    /// Harmonics of one turn of a joint.
    pub fn turning(joint: JointId, harmonics: Vec<u32>) -> Self {
        let (period, period_range, mode, range, pieces) =
            (None, None, TransmissionMode::Periodic, None, None);
        Transmission {
            joint,
            harmonics,
            period,
            period_range,
            by_load: false,
            mode,
            range,
            pieces,
            between: None,
        }
    }

    /// An error in proportion to the joint's value.
    pub fn gain(joint: JointId) -> Self {
        Transmission { mode: TransmissionMode::Gain, ..Transmission::turning(joint, fundamental()) }
    }

    /// A smooth error over this travel (rad or m), cut into so many pieces.
    pub fn curve(joint: JointId, range: [f64; 2], pieces: usize) -> Self {
        let (range, pieces) = (Some(range), Some(pieces));
        Transmission {
            mode: TransmissionMode::Curve,
            range,
            pieces,
            ..Transmission::turning(joint, fundamental())
        }
    }

    fn basis(&self, chain: &Chain) -> Basis {
        let [lower, upper] = travel(self.range, self.joint, chain);
        Basis::Spline { lower, upper, pieces: self.pieces.unwrap_or(4), degree: 3 }
    }

    fn period(&self) -> f64 {
        self.period.unwrap_or(TAU)
    }
}

impl Effect for Transmission {
    const FAMILY: &'static str = "transmission";
    const ABOUT: &'static str = "joint error that follows the joint's own motion: periodic (eccentricity, gear mesh, screw), gain, curve (mode)";

    fn load_dependent(&self) -> bool {
        self.by_load
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let joint = chain.joint(self.joint);
        let scale = if joint.kind == JointKind::Prismatic { 2e-5 * robot_size(chain) } else { 1e-4 };
        let column = |wave: &str, h: u32| {
            Column::new(format!("transmission {} {wave}{h}", joint.name), joint.unit(), scale)
        };
        match self.mode {
            // A part in ten thousand: a count in a turn of an encoder of ten thousand lines, a millimetre in ten metres.
            TransmissionMode::Gain => return vec![Column::new(format!("gain {}", joint.name), "1", 1e-4)],
            TransmissionMode::Curve => {
                let curve = |k| Column::new(format!("curve {} B{k}", joint.name), joint.unit(), scale);
                return (2..=self.basis(chain).len()).map(curve).collect();
            }
            TransmissionMode::Periodic => {}
        }
        let mut columns: Vec<Column> =
            self.harmonics.iter().flat_map(|&h| [column("sin", h), column("cos", h)]).collect();
        if self.by_load {
            // A hundred newton metres (a thousand newton) as large as the constant part.
            let (load, per) = if joint.kind == JointKind::Prismatic {
                ("N", 1e-3)
            } else {
                ("N*m", 1e-2 / robot_size(chain))
            };
            let unit = format!("{}/({load})", joint.unit());
            for k in 0..columns.len() {
                let name = format!("{} by load", columns[k].name);
                columns.push(Column::new(name, unit.clone(), per * scale));
            }
        }
        columns
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let Some(motion) = at.chain().joint_motion(self.joint) else { return };
        if !within(self.between, at.joint(self.joint)) {
            return;
        }
        match self.mode {
            TransmissionMode::Gain => return out.along(0, &motion, at.joint(self.joint)),
            TransmissionMode::Curve => {
                let [lower, upper] = travel(self.range, self.joint, at.chain());
                let middle = 0.5 * (lower + upper);
                self.basis(at.chain()).for_each_from(middle, at.joint(self.joint), |column, value| {
                    out.along(column, &motion, value);
                });
                return;
            }
            TransmissionMode::Periodic => {}
        }
        let angle = TAU * at.joint(self.joint) / self.period();
        let load = self.by_load.then(|| at.joint_load(self.joint).abs());
        for (k, &h) in self.harmonics.iter().enumerate() {
            let (s, c) = (f64::from(h) * angle).sin_cos();
            out.along(2 * k, &motion, s);
            out.along(2 * k + 1, &motion, c);
            if let Some(load) = load {
                let first = 2 * (self.harmonics.len() + k);
                out.along(first, &motion, s * load);
                out.along(first + 1, &motion, c * load);
            }
        }
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        let (Some(joint), Some(motion)) = (at.joint(self.joint), at.chain().joint_motion(self.joint)) else {
            return false;
        };
        let joint = &joint[..at.rows()];
        let here = |q: f64| within(self.between, q);
        match self.mode {
            TransmissionMode::Gain => {
                let value = out.each(joint.len(), |row| if here(joint[row]) { joint[row] } else { 0.0 });
                out.along(0, &motion, value);
                return true;
            }
            TransmissionMode::Curve => {
                let [lower, upper] = travel(self.range, self.joint, at.chain());
                let (basis, middle) = (self.basis(at.chain()), 0.5 * (lower + upper));
                // The unknowns of a curve are one fewer than its functions: it is zero in the middle.
                let values = out.values(basis.len() - 1, |into| {
                    for (row, &q) in joint.iter().enumerate().filter(|(_, q)| here(**q)) {
                        basis.for_each_from(middle, q, |column, value| into[column * LANES + row] += value);
                    }
                });
                values.enumerate().for_each(|(column, value)| out.along(column, &motion, value));
                return true;
            }
            TransmissionMode::Periodic => {}
        }
        let load = self.by_load.then(|| at.joint_load(self.joint));
        let period = self.period();
        for (k, &h) in self.harmonics.iter().enumerate() {
            let mut waves = out.values(2, |into| {
                let (sines, cosines) = into.split_at_mut(LANES);
                for (row, &q) in joint.iter().enumerate().filter(|(_, q)| here(**q)) {
                    (sines[row], cosines[row]) = (f64::from(h) * (TAU * q / period)).sin_cos();
                }
            });
            let (Some(sine), Some(cosine)) = (waves.next(), waves.next()) else { return false };
            out.along(2 * k, &motion, sine);
            out.along(2 * k + 1, &motion, cosine);
            if let Some(load) = load {
                let size = out.each(joint.len(), |row| load[row].abs());
                let first = 2 * (self.harmonics.len() + k);
                let products = [sine, cosine].map(|wave| out.product(wave, size));
                out.along(first, &motion, products[0]);
                out.along(first + 1, &motion, products[1]);
            }
        }
        true
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        joint_moves(Self::FAMILY, self.joint, chain)?;
        ascending(Self::FAMILY, "between", self.between)?;
        if self.mode != TransmissionMode::Curve && (self.range.is_some() || self.pieces.is_some()) {
            return Err(refused(Self::FAMILY, "`range` and `pieces` belong to the mode `curve`"));
        }
        if self.mode != TransmissionMode::Periodic {
            let known = self.period.is_none() && self.period_range.is_none();
            if !known || self.by_load || self.harmonics != fundamental() {
                let reason =
                    "`period`, `period_range`, `harmonics` and `by_load` belong to the mode `periodic`";
                return Err(refused(Self::FAMILY, reason));
            }
            ascending(Self::FAMILY, "range", self.range)?;
            return match self.mode {
                TransmissionMode::Curve => {
                    self.basis(chain).check().map_err(|reason| refused(Self::FAMILY, reason))
                }
                _ => Ok(()),
            };
        }
        let joint = chain.joint(self.joint);
        if self.period.is_none() && joint.kind == JointKind::Prismatic {
            let reason = format!("joint `{}` slides: say the `period`, in m", joint.name);
            return Err(refused(Self::FAMILY, reason));
        }
        let list = &self.harmonics;
        bounded(Self::FAMILY, list.len().saturating_mul(if self.by_load { 4 } else { 2 }))?;
        if list.is_empty() || list.contains(&0) {
            return Err(refused(Self::FAMILY, "`harmonics` count from 1, and one at least is needed"));
        }
        if (0..list.len()).any(|k| list[..k].contains(&list[k])) {
            return Err(refused(Self::FAMILY, "a harmonic stands twice in `harmonics`"));
        }
        positive(Self::FAMILY, "period", self.period(), self.period_range)
    }

    fn shape(&self) -> Vec<NonlinearParameter> {
        if self.mode != TransmissionMode::Periodic {
            return Vec::new();
        }
        let highest = self.harmonics.iter().copied().max().unwrap_or(1);
        let search = Search::Period(self.joint, highest);
        free("period", "rad or m", self.period(), self.period_range, search)
    }

    fn with_nonlinear(&self, values: &[f64]) -> Self {
        Transmission { period: values.first().copied().or(self.period), ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::{Conditions, PostureBuffer, samples};

    #[test]
    fn conforms_on_every_joint() {
        for chain in samples::all() {
            for &joint in chain.movable() {
                let effect = Transmission {
                    harmonics: vec![1, 2, 5],
                    period_range: Some([0.1, 0.3]),
                    ..Transmission::of(joint, 0.2)
                };
                check_effect(&effect, &chain);
                check_effect(&Transmission { by_load: true, ..effect }, &chain);
            }
        }
    }

    #[test]
    fn an_amplitude_by_load_grows_with_it() {
        let chain = samples::heavy();
        let joint = chain.movable()[1];
        let effect = Transmission { by_load: true, ..Transmission::of(joint, 0.25) };
        let conditions = Conditions::at(&chain, &vec![0.4; chain.movable().len()]);
        let mut buffer = PostureBuffer::new(&chain);
        let load = buffer.update(&chain, &conditions).joint_load(joint).abs();
        assert!(load > 1.0, "{load}");
        let entries = emitted(&effect, &chain, &conditions);
        let sum = |column| entries.iter().filter(|e| e.column == column).map(|e| e.value).sum::<f64>();
        for k in 0..2 {
            assert!((sum(k + 2) - load * sum(k)).abs() < 1e-12 * load);
        }
        assert_eq!(Effect::columns(&effect, &chain)[3].name, "transmission a2 cos1 by load");
    }

    #[test]
    fn a_gain_grows_and_a_curve_is_zero_in_the_middle() {
        let chain = samples::ur10();
        for &joint in samples::pps().movable() {
            check_effect(&Transmission::gain(joint), &samples::pps());
            check_effect(&Transmission::curve(joint, [-0.5, 0.5], 3), &samples::pps());
        }
        let at = |effect: &Transmission, q: f64| -> f64 {
            let conditions = Conditions::at(&chain, &[0.0, 0.0, q, 0.0, 0.0, 0.0]);
            emitted(effect, &chain, &conditions).iter().map(|e| e.value.abs()).sum()
        };
        let joint = JointId(3);
        assert!((at(&Transmission::gain(joint), 0.4) - 0.4).abs() < 1e-15);
        let curve = Transmission::curve(joint, [-1.0, 2.0], 4);
        assert_eq!(curve.columns(&chain).len(), 6);
        // Values at the middle cancel in pairs.
        let conditions = Conditions::at(&chain, &[0.0, 0.0, 0.5, 0.0, 0.0, 0.0]);
        for k in 0..6 {
            let entries = emitted(&curve, &chain, &conditions);
            let sum: f64 = entries.iter().filter(|e| e.column == k).map(|e| e.value).sum();
            assert!(sum.abs() < 1e-15, "{k}: {sum}");
        }
        assert!(at(&curve, 1.7) > 0.1);
        let old: Transmission =
            serde_json::from_str(r#"{"joint": 3, "harmonics": [1], "period": 0.2}"#).unwrap();
        assert_eq!(old, Transmission::of(joint, 0.2));
        assert!(!serde_json::to_string(&old).unwrap().contains("mode"));
        let odd = Transmission { period: Some(1.0), ..Transmission::gain(joint) };
        assert!(Effect::validate(&odd, &chain).unwrap_err().to_string().contains("mode `periodic`"));
    }

    #[test]
    fn comes_back_after_a_period_and_not_before() {
        let chain = samples::ur10();
        let effect = Transmission::of(JointId(3), 0.25);
        let at = |q: f64| {
            emitted(&effect, &chain, &Conditions::at(&chain, &[0.0, 0.0, q, 0.0, 0.0, 0.0]))
                .iter()
                .map(|e| e.value)
                .collect()
        };
        let (here, there, half): (Vec<f64>, Vec<f64>, Vec<f64>) = (at(0.4), at(0.65), at(0.525));
        for k in 0..2 {
            assert!((here[k] - there[k]).abs() < 1e-13 && (here[k] + half[k]).abs() < 1e-13);
        }
    }

    #[test]
    fn a_slide_has_to_say_its_period() {
        let effect: Transmission = serde_json::from_str(r#"{"joint": 1}"#).unwrap();
        let error = Effect::validate(&effect, &samples::pps()).unwrap_err();
        assert_eq!(error.to_string(), "effect `transmission`: joint `d1` slides: say the `period`, in m");
        assert!(Effect::validate(&effect, &samples::ur10()).is_ok());
    }
}
