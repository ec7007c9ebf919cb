//! Along which generalized errors a joint's own motion lies.

use crate::{FrameId, JointId, JointKind};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// A small displacement `[tx ty tz rx ry rz]` in the axes of some frame: metres before radians.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Twist {
    /// m.
    pub translation: Vector3<f64>,
    /// rad.
    pub rotation: Vector3<f64>,
}

impl Twist {
    /// The k-th of `[tx ty tz rx ry rz]`.
    pub fn component(&self, index: usize) -> f64 {
        if index < 3 { self.translation[index] } else { self.rotation[index - 3] }
    }
}

/// A joint's own motion: the unit twist of +1 rad (or +1 m) of its variable, and the frame in whose axes it is.
///
/// With standard DH the joint's axis lies in front of `A_i`, in frame i − 1; with MDH and origin + axis
/// it lies in frame i. An axis may be negative or skew: then the twist touches several components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointMotion {
    /// The joint.
    pub joint: JointId,
    /// Turning or sliding.
    pub kind: JointKind,
    /// The frame in whose axes and about whose origin the twist is given.
    pub frame: FrameId,
    /// Unit direction of the axis in that frame.
    pub axis: Vector3<f64>,
}

impl JointMotion {
    /// The unit twist.
    pub fn twist(&self) -> Twist {
        match self.kind {
            JointKind::Prismatic => Twist { translation: self.axis, rotation: Vector3::zeros() },
            _ => Twist { translation: Vector3::zeros(), rotation: self.axis },
        }
    }
}
