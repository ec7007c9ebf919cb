//! The real robot at one configuration: `T = B E_0 A_1 E_1 … A_n E_n · tool · E_tool` with exact `E_i` (Eq. 4).
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | R_i, p_i | `before(i)` | pose | m | measurement, in front of `E_i` |
//! | o_i | `after(i).translation` | 3 | m | measurement, behind `E_i` |
//! | ω_ik | `axes(i)` columns | 3×3 | 1 | measurement: about what a growing rx, ry, rz turns |

use crate::{Aim, GeneralizedErrors, error_matrix, rotation_axes};
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Chain, FrameId, Pose, Posture, TargetId};

/// Frames of the real robot; memory is used again from one posture to the next.
#[derive(Debug, Clone)]
pub struct RealPosture {
    before: Vec<Pose>,
    /// The frame of the tool that is looked at.
    tool: FrameId,
    after: Vec<Pose>,
    axes: Vec<Matrix3<f64>>,
}

impl RealPosture {
    /// Memory for this robot.
    pub fn new(chain: &Chain) -> Self {
        let n = chain.frames().len();
        RealPosture {
            tool: chain.tool_frame(),
            before: vec![Pose::IDENTITY; n],
            after: vec![Pose::IDENTITY; n],
            axes: vec![Matrix3::identity(); n],
        }
    }

    /// Moves to a posture with these generalized errors.
    pub fn update(&mut self, nominal: &Posture<'_>, errors: &GeneralizedErrors) {
        let chain = nominal.chain();
        self.tool = chain.frame_of_tool(nominal.conditions().tool);
        for i in 0..self.before.len() {
            let mut pose = match chain.parent(FrameId(i)) {
                Some(before) => self.after[before.0] * nominal.steps()[i - 1],
                None => chain.base().pose,
            };
            let e = errors.frame(FrameId(i));
            self.before[i] = pose;
            if e.iter().all(|&v| v == 0.0) {
                self.axes[i] = pose.rotation;
            } else {
                self.axes[i] = pose.rotation * rotation_axes(&e);
                pose = pose * error_matrix(&e);
            }
            self.after[i] = pose;
        }
    }

    /// A frame in front of its `E_i`.
    #[inline]
    pub fn before(&self, frame: FrameId) -> &Pose {
        &self.before[frame.0]
    }

    /// A frame behind its `E_i`.
    #[inline]
    pub fn after(&self, frame: FrameId) -> &Pose {
        &self.after[frame.0]
    }

    /// Axes (columns) about which the robot beyond frame i turns when rx, ry, rz of `E_i` grow.
    #[inline]
    pub fn axes(&self, frame: FrameId) -> &Matrix3<f64> {
        &self.axes[frame.0]
    }

    /// Pose of the real tool that is looked at in the measurement frame.
    #[inline]
    pub fn tool(&self) -> &Pose {
        &self.after[self.tool.0]
    }

    /// The frame of the tool that is looked at.
    #[inline]
    pub fn tool_frame(&self) -> FrameId {
        self.tool
    }

    /// The real position of a target (none: the tool's origin) in the measurement frame, m; of two points that met the difference of
    /// [`Aim`].
    pub fn point(&self, chain: &Chain, errors: &GeneralizedErrors, aim: impl Into<Aim>) -> Vector3<f64> {
        let Aim { target, met } = aim.into();
        let own = self.point_of(self.tool, target, chain, errors);
        met.map_or(own, |met| {
            let (tool, target) = met.on(chain);
            (own - self.point_of(tool, target, chain, errors)) * Aim::CONTRAST
        })
    }

    /// A target of a tool (none: its origin), m.
    pub(crate) fn point_of(
        &self,
        tool: FrameId,
        target: Option<TargetId>,
        chain: &Chain,
        errors: &GeneralizedErrors,
    ) -> Vector3<f64> {
        let tool = self.after(tool);
        match target {
            None => tool.translation,
            Some(t) => tool.apply(&(chain.targets()[t.0].position + errors.target(t))),
        }
    }
}
