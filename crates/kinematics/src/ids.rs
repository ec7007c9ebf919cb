//! Identities: joints, frames, targets, axes, and the sites where a generalized error can sit.
//!
//! Numbers are those on the pendant and in the paper: joints 1…n, frames 0…n, then the tool.

use serde::{Deserialize, Serialize};

/// A joint, numbered from 1 at the base: `JointId(3)` is J3.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct JointId(pub usize);

impl JointId {
    /// Position in an array of joints.
    #[inline]
    pub fn index(self) -> usize {
        self.0 - 1
    }
}

/// A frame: 0 is the base, i the frame after joint i, n + 1 the tool (of several tools the first; the others follow).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct FrameId(pub usize);

impl FrameId {
    /// The robot's base, frame 0.
    pub const BASE: FrameId = FrameId(0);
}

/// A measured point, numbered from 0 in the order of the description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct TargetId(pub usize);

/// A tool, numbered from 0 in the order of the description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ToolId(pub usize);

impl ToolId {
    /// The only tool of most robots.
    pub const FIRST: ToolId = ToolId(0);
}

/// One of the six directions of a twist, translations before rotations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// Translation along x, m.
    #[serde(rename = "x")]
    Tx,
    /// Translation along y, m.
    #[serde(rename = "y")]
    Ty,
    /// Translation along z, m.
    #[serde(rename = "z")]
    Tz,
    /// Rotation about x (the paper's pitch), rad.
    Rx,
    /// Rotation about y (the paper's spin), rad.
    Ry,
    /// Rotation about z (the paper's roll), rad.
    Rz,
}

impl Axis {
    /// All six, in the order of a twist.
    pub const ALL: [Axis; 6] = [Axis::Tx, Axis::Ty, Axis::Tz, Axis::Rx, Axis::Ry, Axis::Rz];

    /// The three translations.
    pub const TRANSLATIONS: [Axis; 3] = [Axis::Tx, Axis::Ty, Axis::Tz];

    /// The three rotations.
    pub const ROTATIONS: [Axis; 3] = [Axis::Rx, Axis::Ry, Axis::Rz];

    /// Position in a twist, 0…5.
    #[inline]
    pub fn index(self) -> usize {
        self as usize
    }

    /// True for rotations.
    #[inline]
    pub fn is_rotation(self) -> bool {
        self.index() >= 3
    }

    /// Position among the three coordinate axes, 0…2.
    #[inline]
    pub fn direction(self) -> usize {
        self.index() % 3
    }

    /// The component's word in files: `x y z rx ry rz`.
    pub fn word(self) -> &'static str {
        ["x", "y", "z", "rx", "ry", "rz"][self.index()]
    }

    /// The axis that a file calls by this word.
    pub fn from_word(word: &str) -> Option<Axis> {
        Axis::ALL.into_iter().find(|axis| axis.word() == word)
    }

    /// SI unit of an error along this axis.
    pub fn unit(self) -> &'static str {
        if self.is_rotation() { "rad" } else { "m" }
    }
}

/// The place of one generalized error: a frame and an axis, or a target and a translation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Site {
    /// An error of `E_i`, in the axes of frame i.
    Frame(FrameId, Axis),
    /// An error of a target's position, in the tool's axes; the axis is a translation.
    Target(TargetId, Axis),
}

impl Site {
    /// The axis of this site.
    pub fn axis(self) -> Axis {
        match self {
            Site::Frame(_, axis) | Site::Target(_, axis) => axis,
        }
    }
}
