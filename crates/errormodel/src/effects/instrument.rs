//! What the measurement adds and the robot does not: a joint log that lags, a length scale.
//!
//! ```text
//! lag      δq_j = λ_j (q_j − q_j′)          q_j′ the value at the pose before: the last move is recorded too short by λ
//! scale    δp = s p                         p the measured point, from the origin of the measurement frame
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | λ_j | unknown of each joint, or one for all (`shared`): joint values that are filtered, rounded off, stale, or read before the joint has settled | 1 |
//! | q_j − q_j′ | a derived channel ([`crate::step_channel`]), since effects have no memory | rad or m |
//! | s | unknown: the instrument's unit of length over the true one, less one; refraction index, probe or scale bar | 1 |
//!
//! The robot itself is right: commands are made without these ([`crate::FittedModel::of_robot`]). A scale stretches every length of the robot
//! alike. Where all joints turn and all lengths are unknown, it is not distinguishable from these; a slide, whose scale is no constant error,
//! or a known length tells it. Source of the scale: ASME B89.4.19, section on range errors; Ciddor (1996) for refraction, 1e-6 a kelvin.

use super::checks::{joint_moves, listed_once, refused};
use crate::{Column, Effect, Emission, ModelError, Signal, step_channel};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Axis, Chain, FrameId, JointId, Posture, Site, TargetId};

/// What of the measurement errs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InstrumentMode {
    /// Joint values are recorded late.
    Lag,
    /// The unit of length.
    Scale,
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
}

/// A lag of a thousandth of the last move: a filter of 10 ms, read 70 ms after the end of the move.
const LAG: f64 = 1e-3;
/// A scale of ten parts in a million: ten kelvin in the refraction index, or a scale bar of a metre that is wrong by 10 µm.
const SCALE: f64 = 1e-5;

impl Instrument {
    /// A log that lags in these joints, in each by a fraction of its own.
    pub fn lag(joints: &[JointId]) -> Self {
        Instrument { mode: InstrumentMode::Lag, joints: Some(joints.to_vec()), shared: false }
    }

    /// A wrong unit of length.
    pub fn scale() -> Self {
        Instrument { mode: InstrumentMode::Scale, joints: None, shared: false }
    }

    fn joints(&self) -> &[JointId] {
        self.joints.as_deref().unwrap_or_default()
    }
}

impl Effect for Instrument {
    const FAMILY: &'static str = "instrument";
    const ABOUT: &'static str =
        "what the measurement adds: a joint log that lags (mode `lag`), a wrong unit of length (`scale`)";

    fn load_dependent(&self) -> bool {
        false
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        match self.mode {
            InstrumentMode::Scale => vec![Column::new("scale of the instrument", "1", SCALE)],
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
        // The tool's origin moves with the base, the targets by their own place in the tool.
        let tool = at.frame(FrameId::BASE).rotation.tr_mul(&at.tool().translation);
        for axis in Axis::TRANSLATIONS {
            out.push(0, Site::Frame(FrameId::BASE, axis), tool[axis.direction()]);
        }
        for (target, declared) in chain.targets().iter().enumerate() {
            for axis in Axis::TRANSLATIONS {
                let place = declared.position[axis.direction()];
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
        if self.mode == InstrumentMode::Scale && (self.joints.is_some() || self.shared) {
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
            // The robot is as it was.
            let of_robot = long.of_robot();
            assert_eq!(of_robot.coefficients(), [0.0]);
        }
    }
}
