//! The library of effects: one file each.
//!
//! | what errs | effects |
//! | --- | --- |
//! | where things are | [`Geometric`] |
//! | what yields under load | [`JointCompliance`], [`LinkCompliance`], [`BaseCompliance`], [`LoadNonlinearity`] |
//! | what a joint does beyond what it reports | [`Transmission`], [`Backlash`], [`Coupling`], [`Guideway`] |
//! | what changes with time and temperature | [`Thermal`], [`Drift`], [`Shift`] |
//! | what is only data | [`Expansion`], [`Polynomial`] |

mod geometric;

mod base_compliance;
mod joint_compliance;
mod link_compliance;
mod load_nonlinearity;

mod backlash;
mod coupling;
mod guideway;
mod transmission;

mod drift;
mod shift;
mod thermal;

mod expansion;
mod polynomial;

// Parts that several of them share.
mod spot;
mod travel;

pub use backlash::{Backlash, Side};
pub use base_compliance::{BaseCompliance, Tilt};
pub use coupling::Coupling;
pub use drift::Drift;
pub use expansion::{Basis, Expansion, Factor, Input, Place};
pub use geometric::{AllTargets, Geometric, Where};
pub use guideway::Guideway;
pub use joint_compliance::JointCompliance;
pub use link_compliance::{LinkCompliance, OwnWeight, Section};
pub use load_nonlinearity::LoadNonlinearity;
pub use polynomial::{GroupedError, Order, Polynomial, WrenchComponent, WrenchOf};
pub use shift::Shift;
pub use spot::Spot;
pub use thermal::{Grows, Thermal};
pub use transmission::Transmission;

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
pub(crate) fn refused(kind: &str, reason: impl Into<String>) -> ModelError {
    ModelError::Parameters { kind: kind.into(), reason: reason.into() }
}
