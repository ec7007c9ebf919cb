//! What the robot carries.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// A force and a moment.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Wrench {
    /// N.
    pub force: Vector3<f64>,
    /// N·m, about the point that goes with the wrench.
    pub moment: Vector3<f64>,
}

impl Wrench {
    /// The same wrench about a point that lies at `-arm` from the old one: `arm` leads from the new
    /// point to the old one.
    #[inline]
    pub fn carried_to(&self, arm: &Vector3<f64>) -> Wrench {
        Wrench { force: self.force, moment: self.moment + arm.cross(&self.force) }
    }

    /// In other axes: both vectors are multiplied by `rotation`.
    #[inline]
    pub fn rotated(&self, rotation: &Matrix3<f64>) -> Wrench {
        Wrench { force: rotation * self.force, moment: rotation * self.moment }
    }

    /// `[fx fy fz mx my mz]`.
    #[inline]
    pub fn component(&self, index: usize) -> f64 {
        if index < 3 { self.force[index] } else { self.moment[index - 3] }
    }
}

/// A mass carried by the tool.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Payload {
    /// kg.
    pub mass: f64,
    /// Centre of gravity in the tool frame, m.
    pub com: Vector3<f64>,
}

/// The load at the tool: nothing, a mass, or what a sensor measured.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum Load {
    /// Nothing is carried.
    #[default]
    None,
    /// A mass; gravity makes the wrench.
    Payload(Payload),
    /// The wrench that the load exerts, at the tool's origin, in the tool's axes.
    Wrench(Wrench),
}
