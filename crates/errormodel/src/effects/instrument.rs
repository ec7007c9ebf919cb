//! What the measurement adds and the robot does not: a joint log that lags, a length scale.
//!
//! ```text
//! lag      δq_j = λ_j (q_j − q_j′)          q_j′ the value at the pose before: the last move is recorded too short by λ
//! scale       δp = s p                      p the measured point, from the station of the instrument
//! refraction  δp = k (p_h · p_h) û          û upwards, p_h the level part of p: the beam bends in air that is warmer above than below
//! sight       δp = a p/|p|                  a reflector that is not centred in its ball, a distance meter that is not zero at its mark
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | λ_j | unknown of each joint, or one for all (`shared`): joint values that are filtered, rounded off, stale, or read before the joint has settled | 1 |
//! | q_j − q_j′ | a derived channel ([`crate::step_channel`]), since effects have no memory | rad or m |
//! | s | unknown: the instrument's unit of length over the true one, less one; refraction index, probe or scale bar | 1 |
//!
//! | k | unknown: half the curvature of the beam | 1/m |
//! | a | unknown: offset along the line of sight | m |
//!
//! The station is the origin of the measurement frame unless `station` says where it is.
//!
//! The robot itself is right: commands are made without these ([`crate::FittedModel::of_robot`]). A scale stretches every length of the robot
//! alike. Where all joints turn and all lengths are unknown, it is not distinguishable from these; a slide, whose scale is no constant error,
//! or a known length tells it. Sources: ASME B89.4.19, section on range errors; Ciddor (1996) for refraction, 1e-6 a kelvin.

use super::checks::{joint_moves, listed_once, refused};
use crate::{Column, Effect, Emission, ModelError, Signal, step_channel};
use serde::{Deserialize, Serialize};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Axis, Chain, FrameId, JointId, Posture, Site, TargetId};

/// What of the measurement errs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InstrumentMode {
    /// Joint values are recorded late.
    Lag,
    /// The unit of length.
    Scale,
    /// The beam bends.
    Refraction,
    /// An offset along the line of sight.
    Sight,
}

/// An error of the instrument, or of the log of joint values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Instrument {
    /// What errs.
    pub mode: InstrumentMode,
    /// Of a lag, which needs it: which joints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<Vec<JointId>>,
    /// Of a lag: whether it is the same fraction of the last move of all these joints.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub shared: bool,
    /// Where the instrument stands, m in the measurement frame; its origin when absent. Not of a lag.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub station: Option<[f64; 3]>,
}

/// A lag of a thousandth of the last move: a filter of 10 ms, read 70 ms after the end of the move.
const LAG: f64 = 1e-3;
/// A scale of ten parts in a million: ten kelvin in the refraction index, or a scale bar of a metre that is wrong by 10 µm.
const SCALE: f64 = 1e-5;
/// A micrometre at a metre, 0.1 mm at ten: a kelvin a metre of height.
const BENDING: f64 = 1e-6;
/// A centring of 10 µm.
const OFFSET: f64 = 1e-5;

impl Instrument {
    /// A log that lags in these joints, in each by a fraction of its own.
    pub fn lag(joints: &[JointId]) -> Self {
        Instrument {
            mode: InstrumentMode::Lag,
            joints: Some(joints.to_vec()),
            ..Instrument::of(InstrumentMode::Lag)
        }
    }

    /// A wrong unit of length.
    pub fn scale() -> Self {
        Instrument::of(InstrumentMode::Scale)
    }

    /// One of these, from the origin of the measurement frame; a lag needs its joints.
    pub fn of(mode: InstrumentMode) -> Self {
        Instrument { mode, joints: None, shared: false, station: None }
    }

    /// Displacement of a measured point per unit of the unknown, both in the measurement frame, m.
    fn displacement(&self, point: &Vector3<f64>, up: Option<&Vector3<f64>>) -> Vector3<f64> {
        let from = point - self.station.map_or_else(Vector3::zeros, Vector3::from);
        match (self.mode, up) {
            (InstrumentMode::Scale, _) => from,
            (InstrumentMode::Sight, _) => from.try_normalize(1e-9).unwrap_or_else(Vector3::zeros),
            (InstrumentMode::Refraction, Some(up)) => up * (from.norm_squared() - from.dot(up).powi(2)),
            (InstrumentMode::Refraction, None) | (InstrumentMode::Lag, _) => Vector3::zeros(),
        }
    }

    fn joints(&self) -> &[JointId] {
        self.joints.as_deref().unwrap_or_default()
    }
}

impl Effect for Instrument {
    const FAMILY: &'static str = "instrument";
    const ABOUT: &'static str = "what the measurement adds: a joint log that lags (mode `lag`), a wrong unit of length (`scale`), a beam that bends (`refraction`), an offset along it (`sight`)";

    fn load_dependent(&self) -> bool {
        false
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        match self.mode {
            InstrumentMode::Scale => vec![Column::new("scale of the instrument", "1", SCALE)],
            InstrumentMode::Refraction => vec![Column::new("bending of the beam", "1/m", BENDING)],
            InstrumentMode::Sight => vec![Column::new("offset along the line of sight", "m", OFFSET)],
            InstrumentMode::Lag if self.shared => vec![Column::new("lag of the joint log", "1", LAG)],
            InstrumentMode::Lag => {
                let lag =
                    |joint: &JointId| Column::new(format!("lag {}", chain.joint(*joint).name), "1", LAG);
                self.joints().iter().map(lag).collect()
            }
        }
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let chain = at.chain();
        if self.mode == InstrumentMode::Lag {
            for (k, &joint) in self.joints().iter().enumerate() {
                if let Some(motion) = chain.joint_motion(joint) {
                    out.along(if self.shared { 0 } else { k }, &motion, at.signal(k));
                }
            }
            return;
        }
        // The tool's origin moves with the base, the targets by what they move beyond it.
        let up = chain.gravity_in_measurement_frame().try_normalize(1e-9).map(|down| -down);
        let tool = at.tool();
        let whole = self.displacement(&tool.translation, up.as_ref());
        let base = at.frame(FrameId::BASE).rotation.tr_mul(&whole);
        for axis in Axis::TRANSLATIONS {
            out.push(0, Site::Frame(FrameId::BASE, axis), base[axis.direction()]);
        }
        for (target, declared) in chain.described_targets().iter().enumerate() {
            let there = self.displacement(&tool.apply(&declared.position), up.as_ref());
            let beyond = tool.rotation.tr_mul(&(there - whole));
            for axis in Axis::TRANSLATIONS {
                let place = beyond[axis.direction()];
                if place != 0.0 {
                    out.push(0, Site::Target(TargetId(target), axis), place);
                }
            }
        }
    }

    fn needs(&self) -> Vec<Signal> {
        self.joints().iter().map(|&joint| Signal::Channel(step_channel(joint))).collect()
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        for &joint in self.joints.iter().flatten() {
            joint_moves(Self::FAMILY, joint, chain)?;
        }
        if self.mode == InstrumentMode::Lag && self.joints.is_none() {
            return Err(refused(Self::FAMILY, "the mode `lag` needs `joints`: whose recorded values lag"));
        }
        if self.mode == InstrumentMode::Lag && self.station.is_some() {
            return Err(refused(
                Self::FAMILY,
                "`station` belongs to the modes `scale`, `refraction` and `sight`",
            ));
        }
        if self.station.iter().flatten().any(|value| !value.is_finite()) {
            return Err(refused(Self::FAMILY, "`station` has to be finite"));
        }
        if self.mode == InstrumentMode::Refraction && chain.gravity_in_measurement_frame().norm() < 1e-9 {
            return Err(refused(
                Self::FAMILY,
                "`refraction` bends the beam up or down, and the robot has no gravity",
            ));
        }
        if self.mode != InstrumentMode::Lag && (self.joints.is_some() || self.shared) {
            return Err(refused(Self::FAMILY, "`joints` and `shared` belong to the mode `lag`"));
        }
        listed_once(Self::FAMILY, self.joints.as_deref(), chain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use crate::{AnyEffect, ErrorModel, FittedModel, Schema};
    use truepose_kinematics::nalgebra::DMatrix;
    use truepose_kinematics::{Conditions, samples};

    #[test]
    fn conforms() {
        for chain in samples::all() {
            check_effect(&Instrument::scale(), &chain);
            for mode in [InstrumentMode::Refraction, InstrumentMode::Sight] {
                check_effect(&Instrument { station: Some([3.0, 1.0, 0.5]), ..Instrument::of(mode) }, &chain);
            }
            check_effect(&Instrument::lag(chain.movable()), &chain);
            check_effect(&Instrument { shared: true, ..Instrument::lag(chain.movable()) }, &chain);
        }
    }

    #[test]
    fn a_lag_is_a_fraction_of_the_last_move() {
        let chain = samples::ur10();
        let effect = Instrument::lag(&[JointId(2), JointId(4)]);
        assert_eq!(Effect::needs(&effect)[1], Signal::Channel("step~4".into()));
        let mut conditions = Conditions::at(&chain, &[0.3; 6]);
        conditions.channels = vec![0.4, -0.1];
        let at = |effect: &Instrument, column: usize| -> f64 {
            let all = emitted(effect, &chain, &conditions);
            all.iter().filter(|e| e.column == column).map(|e| e.value).sum()
        };
        assert!((at(&effect, 0).abs() - 0.4).abs() < 1e-15 && (at(&effect, 1).abs() - 0.1).abs() < 1e-15);
        let shared = Instrument { shared: true, ..effect };
        assert_eq!(Effect::columns(&shared, &chain).len(), 1);
        assert!((at(&shared, 0).abs() - 0.3).abs() < 1e-15);
        let refused = |effect: Instrument| Effect::validate(&effect, &chain).unwrap_err().to_string();
        assert!(refused(Instrument { joints: None, ..shared.clone() }).contains("needs `joints`"));
        assert!(refused(Instrument { shared: true, ..Instrument::scale() }).contains("mode `lag`"));
    }

    #[test]
    fn a_scale_stretches_every_measured_point_from_the_origin() {
        for chain in samples::all() {
            let model = ErrorModel::new(chain.clone(), vec![Instrument::scale().boxed()]).unwrap();
            let fitted = |scale| FittedModel::new(model.clone(), vec![scale], DMatrix::zeros(1, 1)).unwrap();
            let (nominal, long) = (fitted(0.0), fitted(1e-4));
            let conditions = Conditions::at(&chain, &vec![0.4; chain.movable().len()]);
            let targets = (0..chain.targets().len()).map(|k| Some(TargetId(k)));
            for target in targets.chain([None]) {
                let point = |fitted: &FittedModel| {
                    let mut at = fitted.bind(&Schema::default()).unwrap();
                    at.predict(&conditions, target).translation
                };
                let expected = 1.0001 * point(&nominal);
                assert!((point(&long) - expected).norm() < 1e-12, "{} {target:?}", chain.name());
            }
            // A beam that bends, and an offset along it, seen from a station: to the square of these sizes.
            let station = Vector3::new(2.5, -3.0, 0.4);
            for mode in [InstrumentMode::Refraction, InstrumentMode::Sight] {
                let effect = Instrument { station: Some(station.into()), ..Instrument::of(mode) };
                let model = ErrorModel::new(chain.clone(), vec![effect.boxed()]).unwrap();
                let off = FittedModel::new(model, vec![1e-5], DMatrix::zeros(1, 1)).unwrap();
                for target in (0..chain.targets().len()).map(|k| Some(TargetId(k))).chain([None]) {
                    let point = |fitted: &FittedModel| {
                        fitted.bind(&Schema::default()).unwrap().predict(&conditions, target).translation
                    };
                    let (true_point, seen) = (point(&nominal), point(&off));
                    let sight = true_point - station;
                    let up = -chain.gravity_in_measurement_frame().normalize();
                    let expected = match mode {
                        InstrumentMode::Sight => sight.normalize() * 1e-5,
                        _ => up * (1e-5 * (sight - up * sight.dot(&up)).norm_squared()),
                    };
                    assert!((seen - true_point - expected).norm() < 1e-12, "{} {mode:?}", chain.name());
                }
            }
            // The robot is as it was.
            let of_robot = long.of_robot();
            assert_eq!(of_robot.coefficients(), [0.0]);
        }
    }
}
