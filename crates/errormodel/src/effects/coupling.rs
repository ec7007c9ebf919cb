//! A joint that another one drags along: a wrist whose motor sits in the forearm, a belt, a bent frame.
//!
//! ```text
//! δq_i = c_1 (q_d − q̄) + Σ_{k=2}^{degree} c_k T_k(x) + Σ_h s_h sin(h q_d) + c_h cos(h q_d)
//! linkage     δq_i = (c_1 cos α + c_2) / sin α,        α = q_i ± q_d + α_0
//! ```
//!
//! The mode `linkage` is a parallelogram or four-bar whose crank, rocker or rods are not as long as drawn: α is the angle between crank and arm,
//! c_1 the difference of crank and rocker, c_2 that of rod and arm, both over the crank (the first variation of the closed chain). α_0
//! (`offset`) is its shape where `offset_range` is given; the sign is that of `crossed`. Source: Hartenberg and Denavit, *Kinematic Synthesis of Linkages*, chapter 10.
//!
//! x is q_d mapped from `range` (its limits when absent; q̄ their middle) to [−1, 1], T_k are Chebyshev's polynomials,
//! which hold their end values outside. c_1 is a ratio: rad or m of this joint a unit of the driving one.

use super::checks::{joint_moves, refused};
use super::expansion::Basis;
use super::robot_size::robot_size;
use super::travel::{ascending, free, travel};
use crate::lanes::{LaneEmission, LanePosture};
use crate::{Column, Effect, Emission, ModelError, NonlinearParameter, Search};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;
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
    /// How it depends on it.
    #[serde(default, skip_serializing_if = "CouplingMode::is_series")]
    pub mode: CouplingMode,
    /// Of a linkage: angle between crank and arm where both joints are zero, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<f64>,
    /// Between which angles `offset` is to be found, rad; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_range: Option<[f64; 2]>,
    /// Of a linkage: whether its angle is the difference of both joints; else it is their sum.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub crossed: bool,
}

/// How a joint depends on another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CouplingMode {
    /// A series in the driving joint.
    #[default]
    Series,
    /// A closed chain of both joints.
    Linkage,
}

impl CouplingMode {
    fn is_series(&self) -> bool {
        *self == CouplingMode::Series
    }
}

/// Where sin α is smaller than this the linkage is at its dead centre; it is never nearer.
const DEAD_CENTRE: f64 = 0.05;

fn linear() -> u32 {
    1
}

const MAX_DEGREE: u32 = 20;

impl Coupling {
    /// The linear coupling of a joint with the one that drags it.
    pub fn of(joint: JointId, driver: JointId) -> Self {
        Coupling {
            joint,
            driver,
            degree: linear(),
            harmonics: Vec::new(),
            range: None,
            mode: CouplingMode::Series,
            offset: None,
            offset_range: None,
            crossed: false,
        }
    }

    /// A parallelogram of a joint and the one that drives it, with this angle where both are zero, rad.
    pub fn linkage(joint: JointId, driver: JointId, offset: f64, crossed: bool) -> Self {
        let mode = CouplingMode::Linkage;
        Coupling { mode, offset: Some(offset), crossed, ..Coupling::of(joint, driver) }
    }

    /// Of a linkage that stands at these angles of the joint and of its driver: cot and 1/sin of the angle between coupler and rocker.
    fn driven(&self, joint: f64, driver: f64) -> [f64; 2] {
        let angle = joint + if self.crossed { -driver } else { driver } + self.offset.unwrap_or(FRAC_PI_2);
        let (sine, cosine) = angle.sin_cos();
        let sine = if sine < 0.0 { sine.min(-DEAD_CENTRE) } else { sine.max(DEAD_CENTRE) };
        [cosine / sine, 1.0 / sine]
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
        if self.mode == CouplingMode::Linkage {
            let name = format!("linkage {} by {}", joint.name, driver.name);
            return ["crank", "rod"]
                .map(|what| Column::new(format!("{name} {what}"), "rad", expected))
                .into();
        }
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
        if self.mode == CouplingMode::Linkage {
            let [ratio, inverse] = self.driven(at.joint(self.joint), q);
            out.along(0, &motion, ratio);
            out.along(1, &motion, inverse);
            return;
        }
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

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        let chain = at.chain();
        let (Some(motion), Some(own), Some(driver)) =
            (chain.joint_motion(self.joint), at.joint(self.joint), at.joint(self.driver))
        else {
            return false;
        };
        let rows = at.rows();
        if self.mode == CouplingMode::Linkage {
            let driven = |row: usize| self.driven(own[row], driver[row]);
            let ratio = out.each(rows, |row| driven(row)[0]);
            let inverse = out.each(rows, |row| driven(row)[1]);
            out.along(0, &motion, ratio);
            out.along(1, &motion, inverse);
            return true;
        }
        let [lower, upper] = travel(self.range, self.driver, chain);
        if self.degree > 0 {
            let value = out.each(rows, |row| driver[row] - 0.5 * (lower + upper));
            out.along(0, &motion, value);
        }
        for k in 2..=self.degree {
            let value = out.each(rows, |row| Basis::chebyshev(k, driver[row], [lower, upper]));
            out.along(k as usize - 1, &motion, value);
        }
        for (k, &h) in self.harmonics.iter().enumerate() {
            let column = self.degree as usize + 2 * k;
            for (more, wave) in [f64::sin, f64::cos].into_iter().enumerate() {
                let value = out.each(rows, |row| wave(f64::from(h) * driver[row]));
                out.along(column + more, &motion, value);
            }
        }
        true
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
        if self.mode == CouplingMode::Linkage {
            let turn = |joint: JointId| chain.joint(joint).kind == JointKind::Revolute;
            if !turn(self.joint) || !turn(self.driver) {
                return refuse("the mode `linkage` is of two joints that turn");
            }
            if self.degree != linear() || !self.harmonics.is_empty() || self.range.is_some() {
                return refuse("`degree`, `harmonics` and `range` belong to the mode `series`");
            }
            if self.offset.is_some_and(|offset| !offset.is_finite()) {
                return refuse("`offset` has to be finite");
            }
            if self.offset.is_none() && self.offset_range.is_some() {
                return refuse("`offset_range` stands without `offset`");
            }
            return ascending(Self::FAMILY, "offset_range", self.offset_range);
        }
        if self.offset.is_some() || self.offset_range.is_some() || self.crossed {
            return refuse("`offset`, `offset_range` and `crossed` belong to the mode `linkage`");
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

    fn shape(&self) -> Vec<NonlinearParameter> {
        self.offset.map_or_else(Vec::new, |at| free("offset", "rad", at, self.offset_range, Search::Smooth))
    }

    fn with_nonlinear(&self, values: &[f64]) -> Self {
        Coupling { offset: self.offset.map(|at| values.first().copied().unwrap_or(at)), ..self.clone() }
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
    fn a_linkage_is_the_first_variation_of_the_closed_chain() {
        let chain = samples::ur10();
        let offset_range = Some([0.5, 2.5]);
        let effect = Coupling::linkage(JointId(3), JointId(2), 1.4, true);
        check_effect(&Coupling { offset_range, ..effect.clone() }, &chain);
        // Crank c, rod h, rocker c', arm L: |c e^(iα) + ... | solved for the rocker's angle by bisection.
        let (arm, crank) = (0.7, 0.2);
        let solved = |alpha: f64, more: [f64; 2]| {
            let (c, rod) = (crank + more[0], arm + more[1]);
            let gap = |beta: f64| {
                let x = arm + crank * beta.cos() - c * alpha.cos();
                let y = crank * beta.sin() - c * alpha.sin();
                x.hypot(y) - rod
            };
            let (mut low, mut high) = (alpha - 0.3, alpha + 0.3);
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                if gap(low) * gap(middle) <= 0.0 { high = middle } else { low = middle }
            }
            0.5 * (low + high) - alpha
        };
        for [q2, q3] in [[0.2, 0.1], [-0.4, 0.3], [0.3, -0.5]] {
            let all = emitted(&effect, &chain, &Conditions::at(&chain, &[0.0, q2, q3, 0.0, 0.0, 0.0]));
            let value =
                |column: usize| -> f64 { all.iter().filter(|e| e.column == column).map(|e| e.value).sum() };
            let more = [2e-6, -3e-6];
            // −(δc cos α − δh)… : rod and crank act against each other.
            let expected = solved(q3 - q2 + 1.4, more);
            let found = -(value(0) * more[0] + value(1) * more[1]) / crank;
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        let slide = Coupling { offset: None, offset_range, ..effect };
        assert!(Effect::validate(&slide, &chain).unwrap_err().to_string().contains("without `offset`"));
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
