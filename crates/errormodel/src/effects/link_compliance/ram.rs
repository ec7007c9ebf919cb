//! A ram: a slide whose free part is a cantilever, longer the farther it is out.
//!
//! ```text
//! ℓ = ℓ_0 ± q        t = (ℓ³/3 F + ℓ²/2 M × a) / EI        φ = (ℓ²/2 a × F + ℓ M) / EI
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | ℓ_0 | `ram`: free length at the slide's zero, its shape where `ram_range` is given; − where it `retracts` | m |
//! | a, F, M | axis of the slide; force and moment across it at the frame behind the slide, the ram's end | 1, N, N·m |
//! | 1/EI | the unknown | 1/(N·m²) |
//!
//! A ram that is drawn in wholly (ℓ ≤ 0) does not bend. Source: Gere and Timoshenko, *Mechanics of Materials*, chapter 9.

use super::LinkCompliance;
use crate::effects::checks::{joint_moves, refused};
use crate::effects::robot_size::robot_size;
use crate::effects::travel::ascending;
use crate::{Column, Effect, Emission, ModelError};
use truepose_kinematics::{Axis, Chain, JointId, JointKind, Posture, Site};

impl LinkCompliance {
    /// A ram with this free length at its zero, m.
    pub fn ram(joint: JointId, length: f64, retracts: bool) -> Self {
        LinkCompliance { ram: Some(length), retracts, ..LinkCompliance::of(joint) }
    }

    fn slide(&self) -> Option<JointId> {
        self.joints.as_deref().and_then(|joints| joints.first()).copied()
    }

    pub(super) fn column_of_ram(&self, chain: &Chain) -> Vec<Column> {
        let name = self.slide().map_or("", |joint| &chain.joint(joint).name);
        // 500 N bend a metre of it by a millimetre.
        let scale = 6e-6 / robot_size(chain).powi(2);
        let bending = Column::new(format!("bending {name} by extension"), "1/(N*m^2)", scale);
        vec![bending.within(0.0, f64::INFINITY)]
    }

    pub(super) fn eval_ram(&self, length: f64, at: &Posture<'_>, out: &mut Emission) {
        let Some(joint) = self.slide() else { return };
        let free = if self.retracts { length - at.joint(joint) } else { length + at.joint(joint) };
        if free <= 0.0 {
            return;
        }
        let (chain, frame) = (at.chain(), at.chain().frame_after(joint));
        let axis = chain.joint(joint).axis_behind();
        let tip = at.wrench(frame);
        let force = tip.force - axis * axis.dot(&tip.force);
        let moment = tip.moment - axis * axis.dot(&tip.moment);
        let shift = force * (free.powi(3) / 3.0) + moment.cross(&axis) * (free * free / 2.0);
        let turn = axis.cross(&force) * (free * free / 2.0) + moment * free;
        for part in Axis::ALL {
            let vector = if part.is_rotation() { &turn } else { &shift };
            out.push(0, Site::Frame(frame, part), vector[part.direction()]);
        }
    }

    pub(super) fn validate_ram(&self, chain: &Chain) -> Result<(), ModelError> {
        let refuse = |reason: &str| Err(refused(Self::FAMILY, reason));
        let Some(length) = self.ram else {
            return match self.ram_range.is_some() || self.retracts {
                true => refuse("`ram_range` and `retracts` stand without `ram`"),
                false => Ok(()),
            };
        };
        let Some([joint]) = self.joints.as_deref() else {
            return refuse("`ram` belongs to one slide: `joints` has to name it alone");
        };
        joint_moves(Self::FAMILY, *joint, chain)?;
        if chain.joint(*joint).kind != JointKind::Prismatic {
            return refuse("`ram` belongs to a slide");
        }
        if !length.is_finite() {
            return refuse("`ram` has to be finite");
        }
        if self.section != super::Section::default() || !self.own_weight.is_declared() {
            return refuse("`section` and `own_weight` do not belong to a ram");
        }
        ascending(Self::FAMILY, "ram_range", self.ram_range)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::nalgebra::Vector3;
    use truepose_kinematics::{Conditions, Load, Payload, samples};

    #[test]
    fn conforms_on_every_slide() {
        for chain in samples::all() {
            for &joint in chain.movable().iter().filter(|&&j| chain.joint(j).kind == JointKind::Prismatic) {
                let ram = LinkCompliance::ram(joint, 0.6, false);
                check_effect(&ram, &chain);
                check_effect(&LinkCompliance { ram_range: Some([0.1, 1.5]), retracts: true, ..ram }, &chain);
            }
        }
        let turn = LinkCompliance::ram(JointId(2), 0.6, false);
        let refused =
            |effect: LinkCompliance| Effect::validate(&effect, &samples::ur10()).unwrap_err().to_string();
        assert!(refused(turn.clone()).contains("a slide"));
        assert!(refused(LinkCompliance { ram: None, retracts: true, ..turn }).contains("without `ram`"));
    }

    #[test]
    fn it_bends_with_the_cube_of_what_is_out() {
        // The couch's first slide is level: the weight hangs across it.
        let chain = samples::pps();
        let joint = JointId(1);
        let at = |q: f64, mass: f64| {
            let load = Load::Payload(Payload { mass, com: Vector3::zeros() });
            let conditions = Conditions::at(&chain, &[q, 0.0, 0.0, 0.0, 0.0, 0.0]).with_load(load);
            let all = emitted(&LinkCompliance::ram(joint, 0.2, false), &chain, &conditions);
            Vector3::from_fn(|k, _| {
                let site = Site::Frame(chain.frame_after(joint), Axis::ALL[k]);
                all.iter().filter(|e| e.site == site).map(|e| e.value).sum::<f64>()
            })
        };
        // The moment of the couch's weight turns about other axes: the force alone.
        let sag = |q: f64| (at(q, 30.0) - at(q, 10.0)).norm();
        let (short, long) = (sag(0.3), sag(0.8));
        assert!((long / short - 8.0).abs() < 1e-6, "{}", long / short);
        assert_eq!(at(-0.3, 30.0), Vector3::zeros());
    }
}
