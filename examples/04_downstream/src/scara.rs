//! A SCARA: two turns about parallel axes, then a quill that slides down.
//!
//! ```text
//! x = l1 cos a + l2 cos(a + b),   y = l1 sin a + l2 sin(a + b),   z = h − q3,      a = (1 + g) q1 + o1,  b = q2 + o2
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | l1, l2 | [`Arm::lengths`] | m |
//! | o1, o2 | [`Arm::offsets`] | rad |
//! | g | [`Arm::gain`] | rad/rad |
//! | h | 0.4 | m |

use truepose_kinematics::{Chain, ChainError, Joint, JointKind, Placement};

const HEIGHT: f64 = 0.4;

/// An arm as it was built. Its kinematics are the two lines above and share nothing with the model that is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arm {
    /// Of the links, m.
    pub lengths: [f64; 2],
    /// Of the encoders, rad.
    pub offsets: [f64; 2],
    /// The first encoder reads that much too little, rad/rad.
    pub gain: f64,
}

impl Arm {
    /// As its drawing has it.
    pub const DRAWN: Arm = Arm { lengths: [0.35, 0.25], offsets: [0.0, 0.0], gain: 0.0 };

    /// Where its tool is, m, at joint values in rad, rad and m.
    pub fn position(&self, [q1, q2, q3]: [f64; 3]) -> [f64; 3] {
        let a = (1.0 + self.gain) * q1 + self.offsets[0];
        let b = a + q2 + self.offsets[1];
        let [l1, l2] = self.lengths;
        [l1 * a.cos() + l2 * b.cos(), l1 * a.sin() + l2 * b.sin(), HEIGHT - q3]
    }
}

/// The drawing's arm for truepose: rows of Denavit and Hartenberg.
///
/// # Errors
/// Never with these numbers.
pub fn nominal() -> Result<Chain, ChainError> {
    let [l1, l2] = Arm::DRAWN.lengths;
    let down = std::f64::consts::PI;
    let row = |d, a, alpha| Placement::Dh { theta: 0.0, d, a, alpha };
    Chain::new(
        "scara",
        vec![
            Joint::new("q1", JointKind::Revolute, row(HEIGHT, l1, 0.0)),
            Joint::new("q2", JointKind::Revolute, row(0.0, l2, down)),
            Joint::new("q3", JointKind::Prismatic, row(0.0, 0.0, 0.0)),
        ],
    )
}
