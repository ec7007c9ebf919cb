//! `<mimic>` of a URDF's joints.

use super::urdf_text::UrdfJoint;
use crate::IoError;
use crate::nearest::listed;
use truepose_kinematics::{JointId, Mimic};

/// The joints of a path that follow others on it; `error` makes an error at a joint.
pub(super) fn urdf_mimics(
    on_path: &[&UrdfJoint],
    error: impl Fn(&str, String) -> IoError,
) -> Result<Vec<Mimic>, IoError> {
    let place = |name: &str| on_path.iter().position(|joint| joint.name == name);
    let mut mimics = Vec::new();
    for (k, described) in on_path.iter().enumerate() {
        let Some(mimic) = &described.mimic else { continue };
        let name = described.name.as_str();
        let Some(driver) = place(&mimic.joint) else {
            let known = listed(on_path.iter().map(|joint| joint.name.as_str()));
            let message = format!(
                "joint `{name}` mimics `{}`, which is not between base and tip; choose other links (joints there: {known})",
                mimic.joint
            );
            return Err(error(name, message));
        };
        // Each follows one other, so that a way longer than all of them goes round.
        let mut at = driver;
        for _ in 0..on_path.len() {
            match on_path[at].mimic.as_ref().and_then(|next| place(&next.joint)) {
                Some(next) => at = next,
                None => break,
            }
        }
        if on_path[at].mimic.is_some() {
            let message = format!("joint `{name}` cannot mimic: joints follow each other in a circle");
            return Err(error(name, message));
        }
        let (ratio, offset) = (mimic.ratio, mimic.offset);
        mimics.push(Mimic { joint: JointId(k + 1), driver: JointId(driver + 1), ratio, offset });
    }
    Ok(mimics)
}
