//! What a series is a function of.

use super::Basis;
use crate::Signal;
use crate::lanes::{LANES, LaneEmission, LanePosture, LaneValue};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Chain, FrameId, JointId, JointKind, Posture};

/// A scalar that a posture has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Input {
    /// A joint's value, rad or m.
    Joint(JointId),
    /// A component (0…2 force, 3…5 moment) of the wrench that a frame carries, N or N·m, in its axes.
    Wrench {
        /// The frame.
        frame: FrameId,
        /// `[fx fy fz mx my mz]`.
        component: usize,
    },
    /// The load about (N·m) or along (N) a joint's axis.
    Load(JointId),
    /// A channel of the data, in its unit.
    Channel(String),
    /// The time, s.
    Time,
    /// The direction in which a joint last moved, −1, 0, +1.
    Approach(JointId),
}

/// One factor of a product: a basis over an input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Factor {
    /// The input.
    pub of: Input,
    /// The functions of it.
    pub basis: Basis,
}

impl Factor {
    /// All functions of the basis in a block of rows; `signal` is the position of its signal among the effect's needs.
    pub(super) fn of_block(
        &self,
        at: &LanePosture<'_>,
        signal: usize,
        out: &mut LaneEmission,
    ) -> Vec<LaneValue> {
        let mut own = [0.0; LANES];
        let u: &[f64] = match &self.of {
            Input::Joint(joint) => at.joint(*joint).unwrap_or(&own),
            Input::Wrench { frame, component } => {
                at.wrench(*frame, *component, &mut own);
                &own
            }
            Input::Load(joint) if at.chain().joint_motion(*joint).is_some() => at.joint_load(*joint),
            Input::Load(_) => &own,
            Input::Channel(_) | Input::Time | Input::Approach(_) => at.signal(signal),
        };
        out.values(self.basis.len(), |into| self.basis.of_block(&u[..at.rows()], into)).collect()
    }
}

impl Input {
    /// Its value; `signal` is the position of its signal among the effect's needs.
    pub(super) fn value(&self, at: &Posture<'_>, signal: usize) -> f64 {
        match self {
            Input::Joint(joint) => at.joint(*joint),
            Input::Wrench { frame, component } => at.wrench(*frame).component(*component),
            Input::Load(joint) => at.joint_load(*joint),
            Input::Channel(_) | Input::Time | Input::Approach(_) => at.signal(signal),
        }
    }

    /// The signal that it reads, if it is one.
    pub(super) fn signal(&self) -> Option<Signal> {
        match self {
            Input::Channel(name) => Some(Signal::Channel(name.clone())),
            Input::Time => Some(Signal::Time),
            Input::Approach(joint) => Some(Signal::Approach(*joint)),
            _ => None,
        }
    }

    pub(super) fn word(&self, chain: &Chain) -> String {
        match self {
            Input::Joint(joint) => chain.joint(*joint).name.clone(),
            Input::Wrench { frame, component } => {
                format!("{}({})", ["fx", "fy", "fz", "mx", "my", "mz"][*component], chain.frame_word(*frame))
            }
            Input::Load(joint) => format!("load({})", chain.joint(*joint).name),
            Input::Channel(name) => name.clone(),
            Input::Time => "time".into(),
            Input::Approach(joint) => format!("approach({})", chain.joint(*joint).name),
        }
    }

    pub(super) fn unit(&self, chain: &Chain) -> String {
        match self {
            Input::Joint(joint) => chain.joint(*joint).unit().into(),
            Input::Wrench { component, .. } => if *component < 3 { "N" } else { "(N*m)" }.into(),
            Input::Load(joint) => {
                if chain.joint(*joint).kind == JointKind::Prismatic { "N" } else { "(N*m)" }.into()
            }
            Input::Channel(name) => format!("[{name}]"),
            Input::Time => "s".into(),
            Input::Approach(_) => String::new(),
        }
    }

    /// A typical size, for the expected size of a coefficient.
    pub(super) fn typical(&self, chain: &Chain) -> f64 {
        match self {
            Input::Joint(joint) => {
                let described = chain.joint(*joint);
                match described.limits {
                    Some((lower, upper)) if lower.is_finite() && upper.is_finite() && upper > lower => {
                        lower.abs().max(upper.abs())
                    }
                    _ => 1.0,
                }
            }
            Input::Wrench { component, .. } => {
                if *component < 3 {
                    500.0
                } else {
                    250.0
                }
            }
            Input::Load(_) => 250.0,
            Input::Channel(_) => 10.0,
            Input::Time => 3600.0,
            Input::Approach(_) => 1.0,
        }
    }
}
