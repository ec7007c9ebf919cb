//! A joint error that is periodic in the joint's own motion: eccentricity, gear mesh, strain wave, a lead screw.
//!
//! `δq_j = Σ_h s_h sin(2πh q_j / P) + c_h cos(2πh q_j / P)`, rad or m; P is one turn unless given, and its shape where
//! `period_range` is given.

use super::checks::{bounded, joint_moves, refused};
use super::travel::{free, positive};
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
}

fn fundamental() -> Vec<u32> {
    vec![1]
}

impl Transmission {
    /// One period of one joint, rad or m.
    pub fn of(joint: JointId, period: f64) -> Self {
        Transmission { joint, harmonics: fundamental(), period: Some(period), period_range: None }
    }

    fn period(&self) -> f64 {
        self.period.unwrap_or(TAU)
    }
}

impl Effect for Transmission {
    const FAMILY: &'static str = "transmission";
    const ABOUT: &'static str =
        "joint error periodic in the joint's own motion (eccentricity, gear mesh, screw)";

    fn load_dependent(&self) -> bool {
        false
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let joint = chain.joint(self.joint);
        let scale = if joint.kind == JointKind::Prismatic { 2e-5 } else { 1e-4 };
        let column = |wave: &str, h: u32| {
            Column::new(format!("transmission {} {wave}{h}", joint.name), joint.unit(), scale)
        };
        self.harmonics.iter().flat_map(|&h| [column("sin", h), column("cos", h)]).collect()
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let Some(motion) = at.chain().joint_motion(self.joint) else { return };
        let angle = TAU * at.joint(self.joint) / self.period();
        for (k, &h) in self.harmonics.iter().enumerate() {
            let (s, c) = (f64::from(h) * angle).sin_cos();
            out.along(2 * k, &motion, s);
            out.along(2 * k + 1, &motion, c);
        }
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        joint_moves(Self::FAMILY, self.joint, chain)?;
        let joint = chain.joint(self.joint);
        if self.period.is_none() && joint.kind == JointKind::Prismatic {
            let reason = format!("joint `{}` slides: say the `period`, in m", joint.name);
            return Err(refused(Self::FAMILY, reason));
        }
        let list = &self.harmonics;
        bounded(Self::FAMILY, list.len().saturating_mul(2))?;
        if list.is_empty() || list.contains(&0) {
            return Err(refused(Self::FAMILY, "`harmonics` count from 1, and one at least is needed"));
        }
        if (0..list.len()).any(|k| list[..k].contains(&list[k])) {
            return Err(refused(Self::FAMILY, "a harmonic stands twice in `harmonics`"));
        }
        positive(Self::FAMILY, "period", self.period(), self.period_range)
    }

    fn shape(&self) -> Vec<NonlinearParameter> {
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
    use truepose_kinematics::{Conditions, samples};

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
            }
        }
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
