//! Where an error that changes with time or temperature sits: in a file `joint = "a3"`, or `frame = "tool"`.

use super::checks::{frame_exists, joint_moves, refused};
use super::expansion::{Expansion, Place};
use super::geometric::EXPECTED_ANGLE;
use crate::lanes::{LaneEmission, LaneValue};
use crate::{Emission, ModelError};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Axis, Chain, FrameId, JointId, Posture, Site};

/// The own motion of a joint, or components of a frame's `E_i`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "InFile", into = "InFile")]
pub enum Spot {
    /// A joint moves beyond what it says, about or along its own axis.
    Joint(JointId),
    /// A frame is displaced: the base, the tool, or one on the way.
    Frame(FrameId),
}

#[derive(Serialize, Deserialize)]
struct InFile {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    joint: Option<JointId>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    frame: Option<FrameId>,
}

impl TryFrom<InFile> for Spot {
    type Error = &'static str;
    fn try_from(file: InFile) -> Result<Self, &'static str> {
        match (file.joint, file.frame) {
            (Some(joint), None) => Ok(Spot::Joint(joint)),
            (None, Some(frame)) => Ok(Spot::Frame(frame)),
            (Some(_), Some(_)) => Err("it has both `joint` and `frame`; say one of them"),
            (None, None) => Err("it lacks its place; add `joint = \"…\"` or `frame = \"…\"` (base, tool)"),
        }
    }
}

impl From<Spot> for InFile {
    fn from(spot: Spot) -> Self {
        match spot {
            Spot::Joint(joint) => InFile { joint: Some(joint), frame: None },
            Spot::Frame(frame) => InFile { joint: None, frame: Some(frame) },
        }
    }
}

/// A component of a spot: its word, and whether it is a rotation.
pub(super) struct Part {
    pub word: String,
    pub rotation: bool,
}

impl Part {
    /// rad or m.
    pub fn unit(&self) -> &'static str {
        if self.rotation { "rad" } else { "m" }
    }

    /// Expected size of a constant error here.
    pub fn expected(&self, chain: &Chain) -> f64 {
        if self.rotation { EXPECTED_ANGLE } else { EXPECTED_ANGLE * chain.characteristic_length() }
    }
}

impl Spot {
    /// The components, in the order in which [`Spot::put`] counts them; all six of a frame where none are named.
    pub(super) fn parts(self, components: Option<&[Axis]>, chain: &Chain) -> Vec<Part> {
        match self {
            Spot::Joint(joint) => {
                let described = chain.joint(joint);
                let rotation = described.unit() == "rad";
                let verb = if rotation { "turn" } else { "slide" };
                vec![Part { word: format!("{verb}({})", described.name), rotation }]
            }
            Spot::Frame(frame) => components
                .unwrap_or(&Axis::ALL)
                .iter()
                .map(|&axis| Part {
                    word: chain.site_word(Site::Frame(frame, axis)),
                    rotation: axis.is_rotation(),
                })
                .collect(),
        }
    }

    /// How many components there are.
    pub(super) fn count(self, components: Option<&[Axis]>) -> usize {
        match self {
            Spot::Joint(_) => 1,
            Spot::Frame(_) => components.map_or(Axis::ALL.len(), <[Axis]>::len),
        }
    }

    /// Emits `value` at every component, the k-th into column `first + k · stride`.
    pub(super) fn put(
        self,
        components: Option<&[Axis]>,
        (first, stride): (usize, usize),
        value: f64,
        at: &Posture<'_>,
        out: &mut Emission,
    ) {
        match self {
            Spot::Joint(joint) => {
                if let Some(motion) = at.chain().joint_motion(joint) {
                    out.along(first, &motion, value);
                }
            }
            Spot::Frame(frame) => {
                for (k, &axis) in components.unwrap_or(&Axis::ALL).iter().enumerate() {
                    out.push(first + k * stride, Site::Frame(frame, axis), value);
                }
            }
        }
    }

    /// As [`Spot::put`], in a block of rows.
    pub(super) fn put_lanes(
        self,
        components: Option<&[Axis]>,
        (first, stride): (usize, usize),
        value: LaneValue,
        (chain, out): (&Chain, &mut LaneEmission),
    ) {
        match self {
            Spot::Joint(joint) => {
                if let Some(motion) = chain.joint_motion(joint) {
                    out.along(first, &motion, value);
                }
            }
            Spot::Frame(frame) => {
                for (k, &axis) in components.unwrap_or(&Axis::ALL).iter().enumerate() {
                    out.push(first + k * stride, Site::Frame(frame, axis), value);
                }
            }
        }
    }

    /// A constant error of the same components.
    pub(super) fn constant(self, components: Option<&[Axis]>) -> Expansion {
        let at = match self {
            Spot::Joint(joint) => Place::Motion { joint },
            Spot::Frame(frame) => {
                Place::Frame { frame, components: components.unwrap_or(&Axis::ALL).to_vec() }
            }
        };
        Expansion { at, factors: Vec::new() }
    }

    pub(super) fn check(
        self,
        kind: &str,
        components: Option<&[Axis]>,
        chain: &Chain,
    ) -> Result<(), ModelError> {
        match self {
            Spot::Joint(joint) => joint_moves(kind, joint, chain)?,
            Spot::Frame(frame) => frame_exists(kind, frame, chain)?,
        }
        match (self, components) {
            (Spot::Joint(_), Some(_)) => {
                Err(refused(kind, "`components` belong to a frame: a joint has its own motion only"))
            }
            (_, Some(list)) => distinct(kind, list),
            _ => Ok(()),
        }
    }
}

/// Refuses an empty list of components, and one with a component twice.
pub(super) fn distinct(kind: &str, components: &[Axis]) -> Result<(), ModelError> {
    let twice = |k: usize| components[..k].contains(&components[k]);
    if components.is_empty() {
        Err(refused(kind, "`components` is empty"))
    } else if (0..components.len()).any(twice) {
        Err(refused(kind, "a component stands twice in `components`"))
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Shift;
    use serde_json::{from_value, json, to_value};

    #[test]
    fn stands_flat_in_a_file() {
        let shift: Shift = from_value(json!({ "frame": 7, "at": 12.5 })).unwrap();
        assert_eq!(shift.spot, Spot::Frame(FrameId(7)));
        assert_eq!(to_value(&shift).unwrap(), json!({ "frame": 7, "at": 12.5 }));
        let shift: Shift = from_value(json!({ "joint": 2, "at": 12.5 })).unwrap();
        assert_eq!(shift.spot, Spot::Joint(JointId(2)));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let error = |value| from_value::<Shift>(value).unwrap_err().to_string();
        assert_eq!(
            error(json!({ "at": 1.0 })),
            "it lacks its place; add `joint = \"…\"` or `frame = \"…\"` (base, tool)"
        );
        assert_eq!(
            error(json!({ "joint": 1, "frame": 1, "at": 1.0 })),
            "it has both `joint` and `frame`; say one of them"
        );
        assert_eq!(error(json!({ "joint": 1, "at": 1.0, "aat": 1.0 })), "unknown field `aat`");
    }
}
