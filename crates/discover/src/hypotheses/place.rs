//! Where an effect sits, in names that a reader knows.

use crate::hypotheses::covariate::Covariate;
use serde::{Deserialize, Serialize};
use truepose_errormodel::effects::Spot;
use truepose_kinematics::{Axis, Chain, FrameId, JointId, TargetId};

/// The keys that locate an effect; absent ones do not apply.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Place {
    /// A joint's name, `base` or `tool`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// The driving joint of a coupling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub driver: Option<String>,
    /// One of `x y z rx ry rz`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub component: Option<String>,
    /// The channel that it follows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
    /// The target.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<String>,
    /// The mode of its effect, where a family has several at one place: `lag`, `scale`, `refraction`, `sight` of the instrument; `bearing`,
    /// `creep`, `temperature` of a compliance; `ram` of a link; `by_load` of a guideway; `arm` of an expansion; `linkage` of a coupling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<String>,
    /// What an unmodelled structure depends on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariate: Option<Covariate>,
    /// The second such input.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariate2: Option<Covariate>,
    /// The declared payload that is wrong, kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level: Option<f64>,
}

impl Place {
    /// A joint.
    pub fn joint(chain: &Chain, joint: JointId) -> Self {
        Place { joint: Some(chain.joint(joint).name.clone()), ..Place::default() }
    }

    /// A frame: base, tool, or the name of the joint in front of it.
    pub fn frame(chain: &Chain, frame: FrameId) -> Self {
        Place { joint: Some(chain.frame_word(frame).into()), ..Place::default() }
    }

    /// A joint's motion or a frame.
    pub fn spot(chain: &Chain, spot: Spot) -> Self {
        match spot {
            Spot::Joint(joint) => Place::joint(chain, joint),
            Spot::Frame(frame) => Place::frame(chain, frame),
        }
    }

    /// A target.
    pub fn target(chain: &Chain, target: TargetId) -> Self {
        Place { target: Some(chain.targets()[target.0].name.clone()), ..Place::default() }
    }

    /// With a channel.
    pub fn following(self, channel: &str) -> Self {
        Place { channel: Some(channel.into()), ..self }
    }

    /// With a component.
    pub fn along(self, axis: Axis) -> Self {
        Place { component: Some(axis.word().into()), ..self }
    }

    /// With what it depends on.
    pub fn depending_on(self, covariate: Covariate) -> Self {
        Place { covariate: Some(covariate), ..self }
    }

    /// The joint, `base` or `tool`, as part of a sentence.
    pub fn part(&self) -> &str {
        match self.joint.as_deref() {
            None => "the robot",
            Some("base") => "the base",
            Some("tool") => "the tool",
            Some(joint) => joint,
        }
    }

    /// In a few words: `a3 by a2`, `tool on temperature`.
    pub fn words(&self) -> String {
        let mut words = Vec::new();
        words.extend(self.mode.clone());
        words.extend(self.joint.clone().or_else(|| self.target.clone()));
        words.extend(self.component.clone());
        words.extend(self.driver.as_ref().map(|driver| format!("by {driver}")));
        words.extend(self.channel.as_ref().map(|channel| format!("on {channel}")));
        words.extend(self.covariate.as_ref().map(|covariate| format!("on {covariate}")));
        words.extend(self.covariate2.as_ref().map(|covariate| format!("and {covariate}")));
        words.extend(self.level.map(|level| format!("at {level} kg")));
        words.join(" ")
    }
}
