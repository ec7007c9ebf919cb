//! An encoder that reads a constant fraction too little: `δq_j = g q_j`, g in rad/rad or m/m.

use serde::{Deserialize, Serialize};
use truepose_errormodel::{Column, Effect, Emission};
use truepose_kinematics::{Chain, JointId, Posture};

/// Of one joint.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EncoderGain {
    /// The joint.
    pub joint: JointId,
}

impl Effect for EncoderGain {
    const FAMILY: &'static str = "acme/encoder_gain";
    const ABOUT: &'static str = "a joint's encoder reads a constant fraction too little";

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        vec![Column::new(format!("gain {}", chain.joint(self.joint).name), "1", 1e-3)]
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        if let Some(motion) = at.chain().joint_motion(self.joint) {
            out.along(0, &motion, at.joint(self.joint));
        }
    }
}
