//! A joint that yields in proportion to the load about (or along) its axis.
//!
//! `δq_j = c_j τ_j`, τ_j the load that the weights exert about joint j's axis, N·m (along it, N, for a slide);
//! c_j > 0 in rad/(N·m) or m/N.

use super::{joint_moves, listed_once};
use crate::{Column, Effect, Emission, ModelError};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Chain, JointId, JointKind, Posture};

/// Compliance of joints, one unknown each.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointCompliance {
    /// Which joints; all that move when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<Vec<JointId>>,
}

impl JointCompliance {
    /// Of one joint.
    pub fn of(joint: JointId) -> Self {
        JointCompliance { joints: Some(vec![joint]) }
    }

    fn joints<'a>(&'a self, chain: &'a Chain) -> &'a [JointId] {
        self.joints.as_deref().unwrap_or_else(|| chain.movable())
    }
}

impl Effect for JointCompliance {
    const KIND: &'static str = "joint_compliance";
    const ABOUT: &'static str = "a joint yields in proportion to the load about (along) its axis";

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        self.joints(chain)
            .iter()
            .map(|&id| {
                let joint = chain.joint(id);
                let (unit, scale) = match joint.kind {
                    JointKind::Prismatic => ("m/N", 1e-7),
                    _ => ("rad/(N*m)", 1e-5),
                };
                Column::new(format!("compliance {}", joint.name), unit, scale)
            })
            .collect()
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        for (column, &joint) in self.joints(at.chain()).iter().enumerate() {
            if let Some(motion) = at.chain().joint_motion(joint) {
                out.along(column, &motion, at.joint_load(joint));
            }
        }
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        for &joint in self.joints.iter().flatten() {
            joint_moves(Self::KIND, joint, chain)?;
        }
        listed_once(Self::KIND, self.joints.as_deref().unwrap_or_default(), chain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::check_effect;
    use truepose_kinematics::samples;

    #[test]
    fn conforms() {
        for chain in samples::all() {
            check_effect(&JointCompliance::default(), &chain);
        }
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
