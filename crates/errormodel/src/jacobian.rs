//! The error Jacobian: how a measured target moves when a generalized error grows (Eq. 6–7).
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | R_i | `before(i).rotation` | 3×3 | 1 | measurement |
//! | ω_ik | `axes(i)` | 3×3 | 1 | measurement |
//! | p | `point`; of two points that met (p_a − p_b)/√2 ([`Aim`]), and so its derivatives | 3 | m | measurement |
//! | J_e | [`ErrorJacobian::matrix`] | 6 × sites | m or rad per m or rad | measurement |
//!
//! ```text
//! ∂p/∂t_ik = R_i e_k              ∂φ/∂t_ik = 0
//! ∂p/∂r_ik = ω_ik × (p − o_i)     ∂φ/∂r_ik = ω_ik
//! ```
//!
//! At zero error ω_ik = R_i e_k and the block of frame i is `[R_i, −R_i [p_i]×; 0, R_i]`, Eq. (7). Elsewhere it is
//! the exact derivative of the product of exact error matrices.

use crate::{Aim, GeneralizedErrors, RealPosture};
use nalgebra::{DMatrix, Vector3};
use truepose_kinematics::{Chain, FrameId, Site, TargetId};

/// Derivatives of one target's position and the tool's orientation by every generalized error.
#[derive(Debug, Clone, Copy)]
pub struct ErrorJacobian<'a> {
    real: &'a RealPosture,
    own: Side<'a>,
    /// The point that it met, where the position is the difference of both.
    met: Option<Side<'a>>,
    point: Vector3<f64>,
}

/// A point of the robot, and what carries it.
#[derive(Debug, Clone, Copy)]
struct Side<'a> {
    tool: FrameId,
    target: Option<TargetId>,
    point: Vector3<f64>,
    /// Whether each frame carries the tool; none where all do.
    path: Option<&'a [bool]>,
}

impl<'a> ErrorJacobian<'a> {
    /// At this real posture, for this target (none: the tool's origin), or for this and the point that it met.
    pub fn new(
        chain: &'a Chain,
        real: &'a RealPosture,
        errors: &GeneralizedErrors,
        aim: impl Into<Aim>,
    ) -> Self {
        let Aim { target, met } = aim.into();
        let side = |tool: FrameId, target: Option<TargetId>| {
            let point = real.point_of(tool, target, chain, errors);
            Side { tool, target, point, path: chain.path(tool) }
        };
        let own = side(real.tool_frame(), target);
        let met = met.map(|met| met.on(chain)).map(|(tool, target)| side(tool, target));
        let point = met.as_ref().map_or(own.point, |met| (own.point - met.point) * Aim::CONTRAST);
        ErrorJacobian { real, own, met, point }
    }

    /// The target's real position in the measurement frame, m; of two points that met the difference of [`Aim`].
    pub fn point(&self) -> &Vector3<f64> {
        &self.point
    }

    /// How that position moves with a site's error, in the measurement frame: m per m, or m per rad.
    #[inline]
    pub fn position(&self, site: Site) -> Vector3<f64> {
        let own = self.own.position(self.real, site);
        self.met.as_ref().map_or(own, |met| (own - met.position(self.real, site)) * Aim::CONTRAST)
    }

    /// How the tool turns with a site's error, in the measurement frame: rad per m, or rad per rad.
    #[inline]
    pub fn rotation(&self, site: Site) -> Vector3<f64> {
        match site {
            Site::Frame(frame, axis) if axis.is_rotation() && !self.own.apart(frame) => {
                self.real.axes(frame).column(axis.direction()).into()
            }
            _ => Vector3::zeros(),
        }
    }

    /// The whole matrix, rows `[x y z rx ry rz]`, one column a site in the order of [`Chain::site_index`].
    pub fn matrix(&self, chain: &Chain) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(6, chain.site_count());
        for column in 0..chain.site_count() {
            let site = chain.site_at(column);
            matrix.fixed_view_mut::<3, 1>(0, column).copy_from(&self.position(site));
            matrix.fixed_view_mut::<3, 1>(3, column).copy_from(&self.rotation(site));
        }
        matrix
    }
}

impl Side<'_> {
    #[inline]
    fn position(&self, real: &RealPosture, site: Site) -> Vector3<f64> {
        match site {
            Site::Frame(frame, _) if self.apart(frame) => Vector3::zeros(),
            Site::Frame(frame, axis) if axis.is_rotation() => {
                let about: Vector3<f64> = real.axes(frame).column(axis.direction()).into();
                about.cross(&(self.point - real.after(frame).translation))
            }
            Site::Frame(frame, axis) => real.before(frame).rotation.column(axis.direction()).into(),
            Site::Target(target, axis) if Some(target) == self.target => {
                real.after(self.tool).rotation.column(axis.direction()).into()
            }
            Site::Target(..) => Vector3::zeros(),
        }
    }

    /// Whether a frame stands on another branch than the tool.
    #[inline]
    fn apart(&self, frame: FrameId) -> bool {
        self.path.is_some_and(|path| !path[frame.0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RobotPoint;
    use proptest::prelude::*;
    use truepose_kinematics::{Conditions, PostureBuffer, ToolId, rotation_log, samples};

    /// Position and orientation of a target with these errors, through the exact chain.
    fn real(chain: &Chain, joints: &[f64], values: &[f64], aim: Aim, tool: ToolId) -> RealParts {
        let conditions = Conditions { tool, ..Conditions::at(chain, joints) };
        let mut buffer = PostureBuffer::new(chain);
        let nominal = buffer.update(chain, &conditions);
        let mut errors = GeneralizedErrors::zero(chain);
        for (index, &value) in values.iter().enumerate() {
            errors.add(chain.site_at(index), value);
        }
        let mut real = RealPosture::new(chain);
        real.update(&nominal, &errors);
        RealParts { real, errors, aim }
    }

    struct RealParts {
        real: RealPosture,
        errors: GeneralizedErrors,
        aim: Aim,
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn agrees_with_central_differences(
            robot in 0usize..10,
            seed in prop::collection::vec(-1.0..1.0f64, 80),
            size in prop::sample::select(vec![0.0, 1e-3, 0.2]),
        ) {
            let chain = if robot < 6 { samples::all().swap_remove(robot) } else { samples::dual() };
            let joints: Vec<f64> = chain.movable().iter().enumerate().map(|(k, _)| 2.0 * seed[k]).collect();
            let values: Vec<f64> = (0..chain.site_count()).map(|k| size * seed[79 - k % 70]).collect();
            let target = if chain.targets().is_empty() { None } else { Some(TargetId(1)) };
            let tool = ToolId(usize::from(robot == 7));
            let met = match robot {
                8 => Some(RobotPoint::Tool(ToolId(1))),
                9 => Some(RobotPoint::Target(TargetId(0))),
                _ => None,
            };
            let (target, tool) = if robot == 9 { (None, ToolId(1)) } else { (target, tool) };
            let aim = Aim { target, met };
            let at = real(&chain, &joints, &values, aim, tool);
            let jacobian = ErrorJacobian::new(&chain, &at.real, &at.errors, at.aim).matrix(&chain);
            for column in 0..chain.site_count() {
                let moved = |d: f64| {
                    let mut v = values.clone();
                    v[column] += d;
                    let r = real(&chain, &joints, &v, aim, tool);
                    (r.real.point(&chain, &r.errors, aim), r.real.tool().rotation)
                };
                let h = 1e-6;
                let (plus, minus) = (moved(h), moved(-h));
                let dp = (plus.0 - minus.0) / (2.0 * h);
                let dr = rotation_log(&(plus.1 * minus.1.transpose())) / (2.0 * h);
                for k in 0..3 {
                    prop_assert!((jacobian[(k, column)] - dp[k]).abs() < 1e-7, "{} position {column}", chain.name());
                    prop_assert!((jacobian[(k + 3, column)] - dr[k]).abs() < 1e-7, "{} turn {column}", chain.name());
                }
            }
        }
    }

    #[test]
    fn is_the_papers_block_at_zero_error() {
        let chain = samples::ur10();
        let joints = [0.3, -1.0, 0.7, 0.2, -0.5, 1.1];
        let at = real(&chain, &joints, &[], Aim::default(), ToolId::FIRST);
        let jacobian = ErrorJacobian::new(&chain, &at.real, &at.errors, None).matrix(&chain);
        for frame in chain.frames() {
            let pose = at.real.after(frame);
            let p = pose.inverse().apply(&at.real.tool().translation);
            let block = jacobian.view((0, 6 * frame.0), (6, 6));
            let lever = -(pose.rotation * truepose_kinematics::skew(&p));
            for row in 0..3 {
                for column in 0..3 {
                    assert!((block[(row, column)] - pose.rotation[(row, column)]).abs() < 1e-15);
                    assert!((block[(row, column + 3)] - lever[(row, column)]).abs() < 1e-14);
                    assert!(block[(row + 3, column)].abs() < 1e-15);
                    assert!((block[(row + 3, column + 3)] - pose.rotation[(row, column)]).abs() < 1e-15);
                }
            }
        }
    }
}
