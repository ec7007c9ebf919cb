//! A joint that another one drags along: a wrist whose motor sits in the forearm, a belt, a bent frame.
//!
//! ```text
//! δq_i = c_1 (q_d − q̄) + Σ_{k=2}^{degree} c_k T_k(x) + Σ_h s_h sin(h q_d) + c_h cos(h q_d)
//! ```
//!
//! x is q_d mapped from `range` (its limits when absent; q̄ their middle) to [−1, 1], T_k are Chebyshev's polynomials,
//! which hold their end values outside. c_1 is a ratio: rad or m of this joint a unit of the driving one.

use super::checks::{joint_moves, refused};
use super::expansion::Basis;
use super::robot_size::robot_size;
use super::travel::{ascending, travel};
use crate::{Column, Effect, Emission, ModelError};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Chain, JointId, JointKind, Posture};

/// Dependence of a joint's error on another joint's position.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// The joint that errs.
    pub joint: JointId,
    /// The joint that drags it.
    pub driver: JointId,
    /// 1 is linear.
    #[serde(default = "linear")]
    pub degree: u32,
    /// Harmonics of a turn of the driving joint.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub harmonics: Vec<u32>,
    /// Range of the driving joint, rad or m; its limits when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
}

fn linear() -> u32 {
    1
}

const MAX_DEGREE: u32 = 20;

impl Coupling {
    /// The linear coupling of a joint with the one that drags it.
    pub fn of(joint: JointId, driver: JointId) -> Self {
        Coupling { joint, driver, degree: linear(), harmonics: Vec::new(), range: None }
    }
}

impl Effect for Coupling {
    const FAMILY: &'static str = "coupling";
    const ABOUT: &'static str =
        "joint error that depends on another joint's position, in proportion or smoothly";

    fn load_dependent(&self) -> bool {
        false
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let (joint, driver) = (chain.joint(self.joint), chain.joint(self.driver));
        let expected = if joint.kind == JointKind::Prismatic { 5e-5 * robot_size(chain) } else { 1e-4 };
        let [lower, upper] = travel(self.range, self.driver, chain);
        let head = format!("coupling {} by {}", joint.name, driver.name);
        let mut columns = Vec::new();
        if self.degree > 0 {
            let unit = format!("{}/{}", joint.unit(), driver.unit());
            columns.push(Column::new(head.clone(), unit, 2.0 * expected / (upper - lower)));
        }
        for k in 2..=self.degree {
            columns.push(Column::new(format!("{head} T{k}"), joint.unit(), expected));
        }
        for h in &self.harmonics {
            columns.push(Column::new(format!("{head} sin{h}"), joint.unit(), expected));
            columns.push(Column::new(format!("{head} cos{h}"), joint.unit(), expected));
        }
        columns
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let Some(motion) = at.chain().joint_motion(self.joint) else { return };
        let q = at.joint(self.driver);
        let [lower, upper] = travel(self.range, self.driver, at.chain());
        if self.degree > 0 {
            out.along(0, &motion, q - 0.5 * (lower + upper));
        }
        for k in 2..=self.degree {
            out.along(k as usize - 1, &motion, Basis::chebyshev(k, q, [lower, upper]));
        }
        for (k, &h) in self.harmonics.iter().enumerate() {
            let column = self.degree as usize + 2 * k;
            let (s, c) = (f64::from(h) * q).sin_cos();
            out.along(column, &motion, s);
            out.along(column + 1, &motion, c);
        }
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        joint_moves(Self::FAMILY, self.joint, chain)?;
        joint_moves(Self::FAMILY, self.driver, chain)?;
        ascending(Self::FAMILY, "range", self.range)?;
        let refuse = |reason: &str| Err(refused(Self::FAMILY, reason));
        if self.joint == self.driver {
            return refuse(
                "`joint` and `driver` are the same; an error by the joint's own motion is a `transmission`",
            );
        }
        if self.degree > MAX_DEGREE || (self.degree == 0 && self.harmonics.is_empty()) {
            return refuse("`degree` is 1 (linear) to 20; 0 only beside `harmonics`");
        }
        if !self.harmonics.is_empty() && chain.joint(self.driver).kind == JointKind::Prismatic {
            return refuse("`harmonics` are those of a turn, but the driving joint slides");
        }
        let list = &self.harmonics;
        if list.contains(&0) || (0..list.len()).any(|k| list[..k].contains(&list[k])) {
            return refuse("`harmonics` count from 1 and stand once each");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::{Conditions, samples};

    #[test]
    fn conforms() {
        for chain in samples::all() {
            let (first, last) = (chain.movable()[0], chain.movable()[chain.movable().len() - 1]);
            for (joint, driver) in [(first, last), (last, first)] {
                check_effect(&Coupling::of(joint, driver), &chain);
                check_effect(&Coupling { degree: 4, ..Coupling::of(joint, driver) }, &chain);
            }
        }
        let harmonics = vec![1, 2];
        let effect = Coupling { degree: 2, harmonics, ..Coupling::of(JointId(6), JointId(5)) };
        check_effect(&effect, &samples::ur10());
    }

    #[test]
    fn the_first_unknown_is_the_ratio() {
        let chain = samples::heavy();
        let effect = Coupling::of(JointId(6), JointId(5));
        let at = |q: f64| {
            emitted(&effect, &chain, &Conditions::at(&chain, &[0.0, 0.0, 0.0, 0.0, q, 0.0]))[0].value
        };
        assert!((at(0.7) - at(0.2) - 0.5).abs() < 1e-15);
        assert_eq!(Effect::columns(&effect, &chain)[0].unit, "rad/rad");
    }

    #[test]
    fn a_joint_does_not_drag_itself() {
        let error = Effect::validate(&Coupling::of(JointId(2), JointId(2)), &samples::ur10()).unwrap_err();
        assert!(error.to_string().contains("`transmission`"), "{error}");
    }
}
