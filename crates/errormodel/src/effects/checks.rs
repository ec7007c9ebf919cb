//! Checks of an effect's parameters against the robot.

use crate::error::ModelError;
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

/// Refuses a list called `joints` that is empty, or in which a joint stands twice; no list stands for all.
pub(crate) fn listed_once(kind: &str, joints: Option<&[JointId]>, chain: &Chain) -> Result<(), ModelError> {
    let Some(joints) = joints else { return Ok(()) };
    if joints.is_empty() {
        return Err(refused(kind, "`joints` is empty; leave it out for all joints"));
    }
    for (k, &joint) in joints.iter().enumerate() {
        if joints[..k].contains(&joint) {
            let reason = format!("joint `{}` stands twice in `joints`", chain.joint(joint).name);
            return Err(refused(kind, reason));
        }
    }
    Ok(())
}

/// Parameters of an effect that make no sense.
/// Refuses an effect with more unknowns than a model may have.
pub(crate) fn bounded(kind: &str, unknowns: usize) -> Result<(), ModelError> {
    crate::error::bounded(|| format!("effect `{kind}`"), unknowns)
}

pub(crate) fn refused(kind: &str, reason: impl Into<String>) -> ModelError {
    ModelError::Parameters { kind: kind.into(), reason: reason.into() }
}
