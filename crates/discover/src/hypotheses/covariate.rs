//! What an unnamed structure may depend on, as written in files.

use truepose_kinematics::{Chain, JointId};

/// What a structure depends on that follows the load of a joint, in words: this, and the joint's name.
pub(crate) const LOADED: &str = "load_";

/// What a structure over the time depends on, in words.
pub(crate) const TIME: &str = "time";

/// How the load about or along a joint is called where something depends on it.
pub(crate) fn load_word(chain: &Chain, joint: JointId) -> String {
    format!("{LOADED}{}", chain.joint(joint).name)
}
