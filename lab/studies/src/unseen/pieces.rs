//! The causes of a robot that has all the usual ones at once, and their right names (table in `everything`).

use truepose_kinematics::Chain;

/// What there is one of for each joint, or for the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Share {
    Gears,
    Friction,
    Hardening,
    Masses,
    Drift,
}

/// One of the causes.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    pub share: Share,
    /// Place and name of the joint; none of the robot's.
    pub joint: Option<(usize, String)>,
}

impl Piece {
    /// Whether this is a right name for it.
    pub fn is_named(&self, family: &str, joint: Option<&str>) -> bool {
        let families: &[&str] = match self.share {
            Share::Gears => &["transmission"],
            Share::Friction => &["backlash"],
            Share::Hardening => &["joint_compliance", "load_nonlinearity"],
            Share::Masses => &["joint_compliance", "load_nonlinearity", "payload"],
            Share::Drift => &["drift", "thermal", "shift"],
        };
        let here = self.joint.as_ref().is_none_or(|(_, name)| joint == Some(name.as_str()));
        families.contains(&family) && here
    }
}

/// All parts, of the robot's joints with their largest loads.
pub fn pieces(chain: &Chain, loads: &[f64]) -> Vec<Piece> {
    let largest = loads.iter().copied().fold(0.0, f64::max);
    let mut pieces = Vec::new();
    for (k, joint) in chain.movable().iter().enumerate() {
        let place = Some((joint.index(), chain.joint(*joint).name.clone()));
        let mut add = |share| pieces.push(Piece { share, joint: place.clone() });
        add(Share::Gears);
        add(Share::Friction);
        if loads[k] > 0.1 * largest {
            add(Share::Hardening);
        }
    }
    pieces.extend([Share::Masses, Share::Drift].map(|share| Piece { share, joint: None }));
    pieces
}
