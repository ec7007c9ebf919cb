//! The products of Eq. (17), and what they are called.

use serde::{Deserialize, Serialize};
use truepose_kinematics::{Chain, FrameId, JointId, Posture};

/// One of the six numbers of a wrench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WrenchComponent {
    /// Force along x, N.
    Fx,
    /// Force along y, N.
    Fy,
    /// Force along z, N.
    Fz,
    /// Moment about x, N·m.
    Mx,
    /// Moment about y, N·m.
    My,
    /// Moment about z, N·m.
    Mz,
}

/// One product of Eq. (17): powers of one joint and of one component of the wrench; power 0 is a constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Term {
    pub joint: Option<(JointId, u32)>,
    /// Power of a component, of the wrench of this frame; none: of the tool.
    pub wrench: Option<(WrenchComponent, u32, Option<FrameId>)>,
}

/// True where this joint's own polynomial acts on this frame.
pub(super) fn lives(joint: JointId, frame: FrameId, chain: &Chain) -> bool {
    chain.joint_motion(joint).is_some_and(|motion| motion.frame == frame)
}

impl WrenchComponent {
    pub(super) fn index(self) -> usize {
        self as usize
    }

    fn word(self) -> &'static str {
        ["fx", "fy", "fz", "mx", "my", "mz"][self.index()]
    }

    /// Unit and a typical size.
    fn unit(self) -> (&'static str, f64) {
        if self.index() < 3 { ("N", 500.0) } else { ("(N*m)", 250.0) }
    }
}

impl Term {
    /// Name, unit and typical size of the product.
    pub fn words(self, chain: &Chain) -> (String, String, f64) {
        let mut factors: Vec<(String, &str, f64, u32)> = Vec::new();
        if let Some((joint, power)) = self.joint {
            let joint = chain.joint(joint);
            let size = match joint.limits {
                Some((lower, upper)) if lower < upper && (upper - lower).is_finite() => {
                    lower.abs().max(upper.abs())
                }
                _ => 1.0,
            };
            factors.push((joint.name.clone(), joint.unit(), size, power));
        }
        if let Some((component, power, frame)) = self.wrench {
            let (unit, size) = component.unit();
            let of = frame.map_or(String::new(), |frame| format!("({})", chain.frame_word(frame)));
            factors.push((format!("{}{of}", component.word()), unit, size, power));
        }
        let raised =
            |word: &str, power: u32| if power == 1 { word.into() } else { format!("{word}^{power}") };
        (
            factors.iter().map(|f| raised(&f.0, f.3)).collect::<Vec<_>>().join("·"),
            factors.iter().map(|f| raised(f.1, f.3)).collect::<Vec<_>>().join("*"),
            factors.iter().map(|f| f.2.powi(f.3 as i32)).product(),
        )
    }

    /// Its value, given the wrench that the error's own terms are functions of.
    pub fn value(self, wrench: &[f64; 6], at: &Posture<'_>) -> f64 {
        let joint = self.joint.map_or(1.0, |(joint, power)| at.joint(joint).powi(power as i32));
        joint
            * self.wrench.map_or(1.0, |(component, power, frame)| {
                let index = component.index();
                let force = frame.map_or(wrench[index], |frame| at.wrench(frame).component(index));
                force.powi(power as i32)
            })
    }
}
