#![doc = include_str!("../README.md")]

mod chain;
mod conditions;
mod coupled;
mod couplings;
mod error;
mod frames;
mod ids;
mod jacobian;
mod joint;
mod kept_length;
pub mod lanes;
mod length;
mod link;
mod load;
mod mimics;
mod motion;
mod pose;
mod posture;
mod prepared;
pub mod samples;
pub mod sines;
mod target;
mod tool;
mod tree;

pub use chain::{Chain, Gravity, GravityFrame};
pub use conditions::{Conditions, Slot};
pub use couplings::{Coupling, Follower, Mimic};
pub use error::ChainError;
pub use ids::{Axis, FrameId, JointId, Site, TargetId, ToolId};
pub use jacobian::joint_jacobian;
pub use joint::{Joint, JointKind, Link, Placement};
pub use link::Span;
pub use load::{Load, Payload, Wrench};
pub use motion::{JointMotion, Twist};
pub use pose::{Pose, nearest_rotation, rotation_log, rotation_vector, skew};
pub use posture::{Posture, PostureBuffer, weigh};
pub use sines::sin_cos;
pub use target::{SEEN, Target};
pub use tool::{Placed, Tool};

pub use nalgebra;
pub use pulp;

/// What most programs need: `use truepose_kinematics::prelude::*`.
pub mod prelude {
    pub use crate::{
        Axis, Chain, ChainError, Conditions, FrameId, Joint, JointId, JointKind, Load, Payload, Placement,
        Pose, Posture, PostureBuffer, Site, Target, TargetId, Tool, ToolId, Wrench,
    };
}
