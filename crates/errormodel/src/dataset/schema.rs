//! Which signals a data set carries besides joints and measured points.

use serde::{Deserialize, Serialize};

/// A numeric column without a fixed meaning: a temperature, a pressure, …
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Channel {
    /// Name of its column.
    pub name: String,
    /// Unit of the stored values (temperatures are in degC; other units stay as the file had them).
    pub unit: String,
    /// True when the unit says that it is a temperature.
    pub temperature: bool,
}

/// The signals of a data set. A model is bound against it once, so that evaluation cannot fail.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Schema {
    /// The channels, in the order of [`super::Dataset::channels`].
    pub channels: Vec<Channel>,
    /// Whether rows carry a time.
    pub time: bool,
    /// Whether rows carry a payload or a measured wrench.
    pub load: bool,
    /// Whether the directions of approach are known (given, or derived from the order of the visits).
    pub approach: bool,
}

impl Schema {
    /// Where the channel of this name stands.
    pub fn channel(&self, name: &str) -> Option<usize> {
        self.channels.iter().position(|channel| channel.name == name)
    }
}
