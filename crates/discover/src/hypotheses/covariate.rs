//! What an unmodelled structure depends on, as typed values with their published words.
//!
//! | word | [`Covariate`] | unit |
//! | --- | --- | --- |
//! | `time` | time of the row | s |
//! | `a2`, `temperature` | value of a joint, or of a channel: a column of the data | rad or m; the channel's |
//! | `approach_a2` | direction in which a joint last moved | −1, 0, 1 |
//! | `load_a2` | load about or along a joint's axis | N·m or N |

use serde::{Deserialize, Serialize};
use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;
use truepose_errormodel::effects::Input;
use truepose_kinematics::Chain;

const TIME: &str = "time";
const APPROACH: &str = "approach_";
const LOAD: &str = "load_";

/// A quantity that an unmodelled structure depends on.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
#[non_exhaustive]
pub enum Covariate {
    /// The time of the row.
    Time,
    /// The value of a joint or a channel, by its name.
    Value(String),
    /// The direction in which this joint last moved.
    Approach(String),
    /// The load about or along the axis of this joint.
    Load(String),
}

impl Covariate {
    /// What an input of a series is called; none of a component of a wrench, which no unmodelled structure depends on.
    pub fn of(chain: &Chain, input: &Input) -> Option<Self> {
        let name = |joint| chain.joint(joint).name.clone();
        Some(match input {
            Input::Joint(joint) => Covariate::Value(name(*joint)),
            Input::Channel(channel) => Covariate::Value(channel.clone()),
            Input::Time => Covariate::Time,
            Input::Approach(joint) => Covariate::Approach(name(*joint)),
            Input::Load(joint) => Covariate::Load(name(*joint)),
            Input::Wrench { .. } => return None,
        })
    }
}

impl fmt::Display for Covariate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Covariate::Time => f.write_str(TIME),
            Covariate::Value(name) => f.write_str(name),
            Covariate::Approach(joint) => write!(f, "{APPROACH}{joint}"),
            Covariate::Load(joint) => write!(f, "{LOAD}{joint}"),
        }
    }
}

impl FromStr for Covariate {
    type Err = Infallible;

    fn from_str(word: &str) -> Result<Self, Infallible> {
        Ok(if word == TIME {
            Covariate::Time
        } else if let Some(joint) = word.strip_prefix(APPROACH) {
            Covariate::Approach(joint.into())
        } else if let Some(joint) = word.strip_prefix(LOAD) {
            Covariate::Load(joint.into())
        } else {
            Covariate::Value(word.into())
        })
    }
}

impl From<String> for Covariate {
    fn from(word: String) -> Self {
        let Ok(covariate) = word.parse();
        covariate
    }
}

impl From<Covariate> for String {
    fn from(covariate: Covariate) -> String {
        covariate.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::{JointId, samples};

    #[test]
    fn words_are_those_of_the_files_and_read_back() {
        let joint = || "a2".to_owned();
        let words = [
            (Covariate::Time, "time"),
            (Covariate::Value(joint()), "a2"),
            (Covariate::Approach(joint()), "approach_a2"),
            (Covariate::Load(joint()), "load_a2"),
        ];
        for (covariate, word) in words {
            assert_eq!(covariate.to_string(), word);
            assert_eq!(word.parse(), Ok(covariate.clone()));
            let json = serde_json::to_string(&covariate).unwrap();
            assert_eq!(json, format!("\"{word}\""));
            assert_eq!(serde_json::from_str::<Covariate>(&json).unwrap(), covariate);
        }
    }

    #[test]
    fn inputs_of_a_series_have_a_covariate_but_for_a_wrench() {
        let chain = samples::ur10();
        let joint = chain.movable()[1];
        let name = chain.joint(joint).name.clone();
        assert_eq!(Covariate::of(&chain, &Input::Load(joint)), Some(Covariate::Load(name.clone())));
        assert_eq!(Covariate::of(&chain, &Input::Joint(joint)), Some(Covariate::Value(name)));
        assert_eq!(Covariate::of(&chain, &Input::Time), Some(Covariate::Time));
        let frame = chain.frame_after(JointId(1));
        assert_eq!(Covariate::of(&chain, &Input::Wrench { frame, component: 0 }), None);
    }
}
