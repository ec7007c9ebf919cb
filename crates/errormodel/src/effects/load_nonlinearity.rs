//! A joint whose deflection is not in proportion to its load.
//!
//! ```text
//! δq_j = Σ_p c_p sign(τ_j) |τ_j|^p + w τ_j / (1 + |τ_j| / τ_s)
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | c_p | the unknown of one power p of `powers` | rad/(N·m)^p or m/N^p |
//! | w | the unknown of the soft range: by how much the joint is more compliant at rest than under a heavy load | rad/(N·m) or m/N |
//! | τ_s | `soft_load`: the load by which half of that is used up; its shape where `soft_range` is given | N·m or N |
//!
//! The linear term is `joint_compliance`, which is declared on its own. All terms are odd and monotone in the load. A joint
//! that stiffens (gear teeth, strain waves, balls: more of their surface touches) has a soft range, or a positive
//! linear term and negative powers. Of a cubic spring `τ = k θ (1 + (θ/θ_h)²)` powers describe the nonlinear part to a few
//! per cent while θ stays below θ_h; loaded ten times as far they miss a seventh of it, and a soft range a fiftieth.
//! Source: Tuttle, *Understanding and modeling the behavior of a harmonic drive* (1992), chapter 4.

use super::checks::{joint_moves, refused};
use super::robot_size::robot_size;
use super::travel::{free, positive};
use crate::lanes::{LaneEmission, LanePosture};
use crate::{Column, Effect, Emission, ModelError, NonlinearParameter, Search};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Chain, JointId, JointKind, Posture};

/// What one joint's deflection has beside its proportion to the load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadNonlinearity {
    /// The joint.
    pub joint: JointId,
    /// Which powers of the load's size, 2 and above; the sign is the load's. 2 and 3 where there is no soft range either.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub powers: Vec<u32>,
    /// Load by which half of a soft range is used up, N·m or N; no soft range when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub soft_load: Option<f64>,
    /// Between which loads `soft_load` is to be found, N·m or N; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub soft_range: Option<[f64; 2]>,
}

/// A load that bends a joint visibly, N·m or N.
const TYPICAL: f64 = 250.0;

impl LoadNonlinearity {
    /// The terms `τ|τ|` and `τ³` of one joint: a spring that stiffens or softens, to second order of what it does.
    pub fn of(joint: JointId) -> Self {
        Self::with_powers(joint, vec![2, 3])
    }

    /// Powers of the load's size, 2 and above.
    pub fn with_powers(joint: JointId, powers: Vec<u32>) -> Self {
        LoadNonlinearity { joint, powers, soft_load: None, soft_range: None }
    }

    /// A soft range alone, half of which is used up by `soft_load`, N·m or N.
    pub fn soft(joint: JointId, soft_load: f64) -> Self {
        LoadNonlinearity { joint, powers: Vec::new(), soft_load: Some(soft_load), soft_range: None }
    }

    fn powers(&self) -> &[u32] {
        if self.powers.is_empty() && self.soft_load.is_none() { &[2, 3] } else { &self.powers }
    }
}

impl Effect for LoadNonlinearity {
    const FAMILY: &'static str = "load_nonlinearity";
    const ABOUT: &'static str =
        "a joint stiffens or softens: deflection by τ|τ|, τ³ … or a soft range, beside joint_compliance";

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let joint = chain.joint(self.joint);
        let size = robot_size(chain);
        let typical = if joint.kind == JointKind::Prismatic { TYPICAL } else { TYPICAL * size };
        let (unit, load, linear) = match joint.kind {
            JointKind::Prismatic => ("m", "N", 1e-7 * size),
            _ => ("rad", "(N*m)", 1e-5 / size),
        };
        // A fifth of the deflection by a typical load is not in proportion to it.
        let power = |&power: &u32| {
            let scale = 0.2 * linear / typical.powi(power as i32 - 1);
            Column::new(format!("load^{power} {}", joint.name), format!("{unit}/{load}^{power}"), scale)
        };
        let soft = || Column::new(format!("soft {}", joint.name), format!("{unit}/{load}"), 0.2 * linear);
        self.powers().iter().map(power).chain(self.soft_load.map(|_| soft())).collect()
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let Some(motion) = at.chain().joint_motion(self.joint) else { return };
        let load = at.joint_load(self.joint);
        for (column, &power) in self.powers().iter().enumerate() {
            out.along(column, &motion, load * load.abs().powi(power as i32 - 1));
        }
        if let Some(soft) = self.soft_load {
            out.along(self.powers().len(), &motion, load / (1.0 + load.abs() / soft));
        }
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        let Some(motion) = at.chain().joint_motion(self.joint) else { return false };
        let load = at.joint_load(self.joint);
        for (column, &power) in self.powers().iter().enumerate() {
            let value = out.each(at.rows(), |row| load[row] * load[row].abs().powi(power as i32 - 1));
            out.along(column, &motion, value);
        }
        if let Some(soft) = self.soft_load {
            let value = out.each(at.rows(), |row| load[row] / (1.0 + load[row].abs() / soft));
            out.along(self.powers().len(), &motion, value);
        }
        true
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        joint_moves(Self::FAMILY, self.joint, chain)?;
        let list = self.powers();
        if list.iter().any(|power| !(2..=7).contains(power)) {
            return Err(refused(Self::FAMILY, "`powers` are 2 to 7; the linear term is `joint_compliance`"));
        }
        if (0..list.len()).any(|k| list[..k].contains(&list[k])) {
            return Err(refused(Self::FAMILY, "a power stands twice in `powers`"));
        }
        match self.soft_load {
            Some(load) => positive(Self::FAMILY, "soft_load", load, self.soft_range),
            None if self.soft_range.is_some() => {
                Err(refused(Self::FAMILY, "`soft_range` stands without `soft_load`"))
            }
            None => Ok(()),
        }
    }

    fn shape(&self) -> Vec<NonlinearParameter> {
        let shape = |load| free("soft_load", "N*m or N", load, self.soft_range, Search::Smooth);
        self.soft_load.map_or_else(Vec::new, shape)
    }

    fn with_nonlinear(&self, values: &[f64]) -> Self {
        LoadNonlinearity { soft_load: values.first().copied().or(self.soft_load), ..self.clone() }
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
                check_effect(&LoadNonlinearity::of(joint), &chain);
                let soft_range = Some([5.0, 200.0]);
                check_effect(&LoadNonlinearity { soft_range, ..LoadNonlinearity::soft(joint, 30.0) }, &chain);
            }
        }
    }

    #[test]
    fn it_is_odd_in_the_load_and_grows_with_its_power() {
        let chain = samples::ur10();
        let effect = LoadNonlinearity { soft_load: Some(40.0), ..LoadNonlinearity::of(JointId(2)) };
        let at = |mass: f64, q2: f64| {
            let load = Load::Payload(Payload { mass, com: Vector3::zeros() });
            let conditions = Conditions::at(&chain, &[0.0, q2, 0.0, 0.0, 0.0, 0.0]).with_load(load);
            let e = emitted(&effect, &chain, &conditions);
            [e[0].value, e[1].value, e[2].value]
        };
        let (light, heavy) = (at(5.0, 0.0), at(10.0, 0.0));
        assert!((heavy[0] / light[0] - 4.0).abs() < 1e-12 && (heavy[1] / light[1] - 8.0).abs() < 1e-12);
        assert!(heavy[2].abs() < 40.0 && heavy[2] / light[2] > 1.0 && heavy[2] / light[2] < 2.0);
        let other = at(5.0, std::f64::consts::PI);
        assert!(light[0] * other[0] < 0.0 && light[1] * other[1] < 0.0 && light[2] * other[2] < 0.0);
    }

    /// Share of what is not linear in a cubic spring's deflection that is left beside a linear term and these, over loads up to `most` k θ_h.
    fn left_of_a_cubic_spring(most: f64, terms: &dyn Fn(f64) -> Vec<f64>) -> f64 {
        use truepose_kinematics::nalgebra::{DMatrix, DVector};
        let deflection = |load: f64| {
            let mut x = load.cbrt();
            (0..60).for_each(|_| x -= (x + x.powi(3) - load) / (1.0 + 3.0 * x * x));
            x
        };
        let loads: Vec<f64> = (0..201).map(|k| most * (f64::from(k) / 100.0 - 1.0)).collect();
        let seen = DVector::from_iterator(loads.len(), loads.iter().map(|&load| deflection(load)));
        let left = |columns: &dyn Fn(f64) -> Vec<f64>| {
            let rows: Vec<_> = loads.iter().map(|&load| DVector::from_vec(columns(load))).collect();
            let a = DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
            let fitted = a.clone().svd(true, true).solve(&seen, 1e-13).unwrap();
            (&seen - a * fitted).norm()
        };
        left(&|load| [vec![load], terms(load)].concat()) / left(&|load| vec![load])
    }

    #[test]
    fn a_soft_range_goes_on_where_powers_end() {
        let powers = |load: f64| vec![load * load.abs(), load.powi(3)];
        let soft = |most: f64| {
            let of = |share: f64| {
                left_of_a_cubic_spring(most, &move |load| vec![load / (1.0 + load.abs() / (share * most))])
            };
            (1..60).map(|k| of(0.02 * f64::from(k))).fold(f64::INFINITY, f64::min)
        };
        assert!(left_of_a_cubic_spring(1.0, &powers) < 0.03);
        let (far, near) = (left_of_a_cubic_spring(10.0, &powers), soft(10.0));
        assert!(far > 0.1 && near < 0.03, "{far} {near}");
    }
}
