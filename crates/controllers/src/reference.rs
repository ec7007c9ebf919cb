//! Frames, tools and loads of a point, as the program states them.

use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::Vector3;

/// A frame or a tool of a point.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// The robot's base, or its flange.
    Identity,
    /// One that the program names.
    Named(String),
    /// One whose value stands in the program, m.
    Value(Pose),
    /// Unknown, for this reason.
    Unknown(String),
    /// Not compensated for this reason, whatever else is stated.
    Excluded(String),
}

impl Reference {
    /// In words.
    pub fn words(&self) -> String {
        match self {
            Reference::Identity => "none".into(),
            Reference::Named(name) => name.clone(),
            Reference::Value(_) => "given in the program".into(),
            Reference::Unknown(_) => "unknown".into(),
            Reference::Excluded(_) => "not compensated".into(),
        }
    }
}

/// What the robot carries at a point, as the program states it.
#[derive(Debug, Clone, PartialEq)]
pub enum Carried {
    /// It is not stated, or not clear, for this reason.
    Open(String),
    /// A load.
    Mass {
        /// As the program calls it.
        name: String,
        /// kg.
        mass: f64,
        /// Centre of gravity in the controller's flange, m.
        com: Vector3<f64>,
    },
}

impl Carried {
    pub(crate) fn unstated() -> Carried {
        Carried::Open("the program states none".into())
    }
}
