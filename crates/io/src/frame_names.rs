//! Joints that makers call by the word of a frame: Universal Robots' first joint is the `base`.

use std::borrow::Cow;
use truepose_kinematics::{Chain, JointId};

/// Words of frames in models and results.
pub(crate) const FRAMES: [&str; 3] = ["base", "tool", "targets"];

/// The name of a joint that a file calls so: with the word of a frame it is, for example, `base_joint`.
pub(crate) fn joint_name(called: &str) -> Cow<'_, str> {
    if FRAMES.contains(&called) { Cow::Owned(format!("{called}_joint")) } else { Cow::Borrowed(called) }
}

/// The joint that a file calls so.
pub(crate) fn joint_called(chain: &Chain, called: &str) -> Option<JointId> {
    chain.joint_named(called).or_else(|| chain.joint_named(&joint_name(called)))
}
