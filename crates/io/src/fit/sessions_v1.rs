//! The installations that a fit knows, where they are several.

use super::robot_v1::{PoseV1, pose};
use serde::{Deserialize, Serialize};
use truepose_errormodel::Installed;
use truepose_kinematics::Pose;

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct SessionV1 {
    name: String,
    /// Measurement frame of the first session ← that of this one.
    frame: PoseV1,
}

impl From<&Installed> for SessionV1 {
    fn from(installed: &Installed) -> Self {
        SessionV1 { name: installed.name.clone(), frame: (&installed.frame).into() }
    }
}

/// Sessions as a fit has them.
pub(super) fn read(sessions: Vec<SessionV1>) -> Result<Vec<Installed>, String> {
    let mut installed: Vec<Installed> = Vec::with_capacity(sessions.len());
    for (k, session) in sessions.into_iter().enumerate() {
        let frame = pose(session.frame, "the frame of a session");
        let frame: Pose = frame.map_err(|error| format!("`sessions[{k}].frame`: {error}"))?;
        if session.name.is_empty() || installed.iter().any(|known| known.name == session.name) {
            return Err(format!("`sessions[{k}].name` is empty or stands twice"));
        }
        installed.push(Installed { name: session.name, frame });
    }
    Ok(installed)
}
