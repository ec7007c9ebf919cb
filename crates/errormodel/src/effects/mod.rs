//! The library of effects: one file each.

mod expansion;
mod geometric;
mod joint_compliance;

pub use expansion::{Basis, Expansion, Factor, Input, Place};
pub use geometric::{AllTargets, Geometric, Where};
pub use joint_compliance::JointCompliance;

use crate::ModelError;
use truepose_kinematics::{Chain, FrameId, JointId, TargetId};

pub(crate) fn joint_exists(kind: &str, joint: JointId, chain: &Chain) -> Result<(), ModelError> {
    let count = chain.joints().len();
    if (1..=count).contains(&joint.0) {
        Ok(())
    } else {
        Err(ModelError::NoSuchPlace { kind: kind.into(), what: "joint", number: joint.0, count })
    }
}

pub(crate) fn joint_moves(kind: &str, joint: JointId, chain: &Chain) -> Result<(), ModelError> {
    joint_exists(kind, joint, chain)?;
    if chain.joint(joint).moves() {
        Ok(())
    } else {
        Err(ModelError::JointIsFixed { kind: kind.into(), joint: chain.joint(joint).name.clone() })
    }
}

pub(crate) fn frame_exists(kind: &str, frame: FrameId, chain: &Chain) -> Result<(), ModelError> {
    let count = chain.frames().len();
    if frame.0 < count {
        Ok(())
    } else {
        Err(ModelError::NoSuchPlace { kind: kind.into(), what: "frame", number: frame.0, count })
    }
}

pub(crate) fn target_exists(kind: &str, target: TargetId, chain: &Chain) -> Result<(), ModelError> {
    let count = chain.targets().len();
    if target.0 < count {
        Ok(())
    } else {
        Err(ModelError::NoSuchPlace { kind: kind.into(), what: "target", number: target.0, count })
    }
}
