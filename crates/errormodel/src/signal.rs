//! Inputs of an effect besides joint values and loads.

use truepose_kinematics::{Chain, JointId};

/// An input that not every data set has. Asked for by name, resolved once, then read as `at.signal(k)`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Signal {
    /// The time of the row, s.
    Time,
    /// The direction in which a joint last moved: −1, 0, +1.
    Approach(JointId),
    /// A channel, by its name.
    Channel(String),
}

impl Signal {
    /// In words.
    pub fn describe(&self, chain: &Chain) -> String {
        match self {
            Signal::Time => "a `time` column".into(),
            Signal::Approach(joint) => format!("the approach of joint `{}`", chain.joint(*joint).name),
            Signal::Channel(name) => format!("a channel `{name}`"),
        }
    }
}
