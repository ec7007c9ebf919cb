//! Every input of the model at one moment: at fit time and at run time alike.

use crate::{Chain, Load, ToolId};

/// Joints, load, approach, time and channels at one moment.
#[derive(Debug, PartialEq, Default)]
pub struct Conditions {
    /// Variables of the movable joints in the order of [`Chain::movable`], rad or m: the controller's values, but for coupled joints
    /// ([`Chain::joints_from_controller`]).
    pub joints: Vec<f64>,
    /// The tool that is looked at, and that carries the load.
    pub tool: ToolId,
    /// What the tool carries.
    pub load: Load,
    /// When, s.
    pub time: f64,
    /// Direction in which each movable joint last moved: −1, 0 or +1.
    pub approach: Vec<f64>,
    /// Values of the channels (temperature, …), in the order of the schema that names them.
    pub channels: Vec<f64>,
}

impl Clone for Conditions {
    fn clone(&self) -> Self {
        Conditions {
            joints: self.joints.clone(),
            tool: self.tool,
            load: self.load,
            time: self.time,
            approach: self.approach.clone(),
            channels: self.channels.clone(),
        }
    }

    /// Without allocating where the lists have room: a derived `clone_from` would.
    fn clone_from(&mut self, other: &Self) {
        self.joints.clone_from(&other.joints);
        self.tool = other.tool;
        self.load = other.load;
        self.time = other.time;
        self.approach.clone_from(&other.approach);
        self.channels.clone_from(&other.channels);
    }
}

impl Conditions {
    /// The robot at these joint values (rad or m, movable joints only), unloaded, at time zero.
    pub fn at(chain: &Chain, joints: &[f64]) -> Self {
        Conditions {
            joints: joints.to_vec(),
            approach: vec![0.0; chain.movable().len()],
            ..Conditions::default()
        }
    }

    /// With a load.
    pub fn with_load(mut self, load: Load) -> Self {
        self.load = load;
        self
    }

    /// The value that a slot points to.
    pub fn slot(&self, slot: Slot) -> f64 {
        match slot {
            Slot::Time => self.time,
            Slot::Approach(k) => self.approach[k],
            Slot::Channel(k) => self.channels[k],
        }
    }
}

/// A place in [`Conditions`] to which a signal was resolved, once, before any row is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    /// [`Conditions::time`].
    Time,
    /// An entry of [`Conditions::approach`].
    Approach(usize),
    /// An entry of [`Conditions::channels`].
    Channel(usize),
}
