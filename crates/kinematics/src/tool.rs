//! Where base and tools stand, and whether that is known.

use crate::{FrameId, Joint, JointId, Pose};
use serde::{Deserialize, Serialize};

/// A nominal pose, and whether it can be relied on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    /// The nominal pose, m.
    pub pose: Pose,
    /// False when it is a hint at most, to be found from the data.
    pub known: bool,
}

impl Default for Placed {
    fn default() -> Self {
        Placed { pose: Pose::IDENTITY, known: true }
    }
}

/// What is mounted on a frame, with measured points of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Tool {
    /// Its name in the `tool` column of the data.
    pub name: String,
    /// The frame that carries it: behind a joint, or the base.
    pub frame: FrameId,
    /// That frame → tool frame, m.
    pub placed: Placed,
    /// Its word in files and reports.
    pub(crate) word: String,
}

impl Tool {
    /// The only tool of a robot, behind its last joint.
    pub(crate) fn at_the_end_of(joints: &[Joint]) -> Self {
        let word = || "tool".to_owned();
        Tool { name: word(), frame: FrameId(joints.len()), placed: Placed::default(), word: word() }
    }

    /// A tool on the frame behind a joint (none: on the base).
    pub fn on(name: impl Into<String>, joint: Option<JointId>, placed: Placed) -> Self {
        let name = name.into();
        let word = format!("tool {name}");
        Tool { name, frame: joint.map_or(FrameId::BASE, |joint| FrameId(joint.0)), placed, word }
    }
}
