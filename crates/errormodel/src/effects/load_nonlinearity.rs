//! A joint whose deflection is not in proportion to its load.
//!
//! `δq_j = Σ_p c_p sign(τ_j) |τ_j|^p`, p of `powers`: `τ|τ|` and `τ³` beside the linear term of `joint_compliance`, which
//! is declared on its own. All are odd and monotone in the load: a joint that stiffens (gear teeth, strain waves, balls:
//! more of their surface touches) has a positive linear term and negative ones here, and the sum stays monotone as long
//! as `c_1 + Σ p c_p |τ|^(p−1) > 0` over the loads that were seen. Source: Tuttle, *Understanding and modeling the
//! behavior of a harmonic drive* (1992), chapter 4.

use super::{joint_moves, refused};
use crate::{Column, Effect, Emission, ModelError};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Chain, JointId, JointKind, Posture};

/// Higher powers of one joint's load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadNonlinearity {
    /// The joint.
    pub joint: JointId,
    /// Which powers of the load's size, 2 and above; the sign is the load's.
    #[serde(default = "both")]
    pub powers: Vec<u32>,
}

fn both() -> Vec<u32> {
    vec![2, 3]
}

/// A load that bends a joint visibly, N·m or N.
const TYPICAL: f64 = 250.0;

impl LoadNonlinearity {
    /// The terms `τ|τ|` and `τ³` of one joint: a spring that stiffens or softens, to second order of what it does.
    pub fn of(joint: JointId) -> Self {
        LoadNonlinearity { joint, powers: both() }
    }
}

impl Effect for LoadNonlinearity {
    const KIND: &'static str = "load_nonlinearity";
    const ABOUT: &'static str =
        "a joint stiffens or softens: deflection by τ|τ|, τ³ … beside joint_compliance";

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let joint = chain.joint(self.joint);
        let (unit, load, linear) = match joint.kind {
            JointKind::Prismatic => ("m", "N", 1e-7),
            _ => ("rad", "(N*m)", 1e-5),
        };
        let column = |&power: &u32| {
            // A fifth of the deflection by a typical load is not in proportion to it.
            let scale = 0.2 * linear / TYPICAL.powi(power as i32 - 1);
            Column::new(format!("load^{power} {}", joint.name), format!("{unit}/{load}^{power}"), scale)
        };
        self.powers.iter().map(column).collect()
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let Some(motion) = at.chain().joint_motion(self.joint) else { return };
        let load = at.joint_load(self.joint);
        for (column, &power) in self.powers.iter().enumerate() {
            out.along(column, &motion, load * load.abs().powi(power as i32 - 1));
        }
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        joint_moves(Self::KIND, self.joint, chain)?;
        let list = &self.powers;
        if list.is_empty() || list.iter().any(|power| !(2..=7).contains(power)) {
            return Err(refused(Self::KIND, "`powers` are 2 to 7; the linear term is `joint_compliance`"));
        }
        if (0..list.len()).any(|k| list[..k].contains(&list[k])) {
            return Err(refused(Self::KIND, "a power stands twice in `powers`"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::nalgebra::Vector3;
    use truepose_kinematics::{Conditions, Load, Payload, samples};

    #[test]
    fn conforms() {
        for chain in samples::all() {
            for &joint in chain.movable() {
                check_effect(&LoadNonlinearity { joint, powers: vec![2, 3] }, &chain);
            }
        }
    }

    #[test]
    fn it_is_odd_in_the_load_and_grows_with_its_power() {
        let chain = samples::ur10();
        let effect = LoadNonlinearity { joint: JointId(2), powers: vec![2, 3] };
        let at = |mass: f64, q2: f64| {
            let load = Load::Payload(Payload { mass, com: Vector3::zeros() });
            let conditions = Conditions::at(&chain, &[0.0, q2, 0.0, 0.0, 0.0, 0.0]).with_load(load);
            let e = emitted(&effect, &chain, &conditions);
            [e[0].value, e[1].value]
        };
        let (light, heavy) = (at(5.0, 0.0), at(10.0, 0.0));
        assert!((heavy[0] / light[0] - 4.0).abs() < 1e-12 && (heavy[1] / light[1] - 8.0).abs() < 1e-12);
        let other = at(5.0, std::f64::consts::PI);
        assert!(light[0] * other[0] < 0.0 && light[1] * other[1] < 0.0);
    }
}
