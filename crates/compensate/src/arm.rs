//! The robot boiled down to what moves: constants between motions are multiplied out once.
//!
//! ```text
//! A_i(q) = pre_i · M(q) · post_i              M: a turn about, or a slide along, z
//! T = C_0 M(q_1) C_1 M(q_2) … M(q_n) C_n      C_k = post E pre, with exact error matrices E
//! J column k = [z_k × (p − o_k); z_k]  for a turn,  [z_k; 0]  for a slide
//! ```
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | z_k, o_k | [`Reached::axes`], [`Reached::origins`] | 3 | 1, m | measurement: the *real* axis of joint k |
//! | T | [`Reached::tool`] | pose | m | measurement |
//! | ε | `errors` | 6 a frame | m, rad | frame i |
//!
//! An axis that is not z is turned to z by a constant rotation on either side. Components of an `E_i` that never change are
//! part of the constants: `E = T · Ry Rz Rx`, so that one that varies about z costs one turn of two columns at run time.

use crate::command::MOST;
use nalgebra::{Matrix3, Rotation3, Vector3};
use truepose_errormodel::error_matrix;
use truepose_kinematics::{Chain, FrameId, JointId, JointKind, Placement, Pose, ToolId, sin_cos};

/// One factor of T.
#[derive(Debug, Clone)]
pub(crate) enum Factor {
    /// A constant, all neighbouring ones multiplied out.
    Constant(Pose),
    /// A constant translation.
    Shift(Vector3<f64>),
    /// A constant turn about a coordinate axis: its sine and cosine.
    Spin(usize, f64, f64),
    /// Three generalized errors, from this one on, as a translation.
    Shifted(usize),
    /// This generalized error, as a turn about this coordinate axis.
    Turned(usize, usize),
    /// The next joint turns.
    Turn,
    /// The next joint slides.
    Slide,
    /// No factor: the next joint does not carry the tool.
    Skip,
    /// No factor: a mark at this place.
    Mark(Mark),
}

/// A mark whose place is computed: which, and where its point and its direction lie in the axes of the factors so far.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mark {
    pub what: usize,
    pub point: Vector3<f64>,
    pub direction: Vector3<f64>,
}

/// A mark in a frame of the robot, in its axes.
pub(crate) type Marked = (FrameId, Mark);

/// The factors of T in order.
#[derive(Debug, Clone)]
pub(crate) struct Arm {
    factors: Vec<Factor>,
    slides: [bool; MOST],
    joints: usize,
}

/// Where the arm is at one configuration.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reached {
    pub tool: Pose,
    /// The target's point.
    pub point: Vector3<f64>,
    pub axes: [Vector3<f64>; MOST],
    pub origins: [Vector3<f64>; MOST],
}

impl Reached {
    pub fn nowhere() -> Self {
        Reached {
            tool: Pose::IDENTITY,
            point: Vector3::zeros(),
            axes: [Vector3::zeros(); MOST],
            origins: [Vector3::zeros(); MOST],
        }
    }
}

impl Arm {
    /// From the base to a tool of a robot with these generalized errors, six a frame, constant except at those that `moves` marks. Joints that
    /// do not carry the tool have an axis of zero.
    pub fn to_tool(chain: &Chain, tool: ToolId, errors: &[f64], moves: &[bool]) -> Self {
        Arm::with_marks(chain, tool, errors, moves, &[])
    }

    /// The same with marks, each behind the errors of its frame.
    pub fn with_marks(chain: &Chain, tool: ToolId, errors: &[f64], moves: &[bool], marks: &[Marked]) -> Self {
        let mut made = Factors { factors: Vec::new(), pending: chain.base().pose };
        let mut slides = [false; MOST];
        let mut joints = 0;
        made.errors(0, errors, moves);
        made.marks(0, marks);
        for (index, joint) in chain.joints().iter().enumerate() {
            if !chain.carries(FrameId(index + 1), tool) {
                if joint.moves() {
                    made.factors.push(Factor::Skip);
                    joints += 1;
                }
                continue;
            }
            let (pre, post) = around_motion(chain, JointId(index + 1));
            made.constant(&pre);
            match joint.kind {
                JointKind::Fixed => {}
                JointKind::Revolute => {
                    made.push(Factor::Turn);
                    joints += 1;
                }
                JointKind::Prismatic => {
                    made.push(Factor::Slide);
                    if let Some(slot) = slides.get_mut(joints) {
                        *slot = true;
                    }
                    joints += 1;
                }
            }
            made.constant(&post);
            made.errors(index + 1, errors, moves);
            made.marks(index + 1, marks);
        }
        made.constant(&chain.tools()[tool.0].placed.pose);
        made.errors(chain.frame_of_tool(tool).0, errors, moves);
        made.flush();
        Arm { factors: made.factors, slides, joints: joints.min(MOST) }
    }

    /// Whether joint k slides.
    pub fn slides(&self, k: usize) -> bool {
        self.slides[k]
    }

    /// The factors in order.
    pub fn factors(&self) -> &[Factor] {
        &self.factors
    }

    /// How many joints move.
    pub fn joints(&self) -> usize {
        self.joints
    }

    /// Moves there. `turns` are sine and cosine of each q; `errors` are six a frame; those that do not move are not read.
    pub fn reach(&self, q: &[f64], turns: &[(f64, f64)], errors: &[f64], out: &mut Reached) {
        let (mut x, mut y, mut z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let mut at = Vector3::zeros();
        let mut k = 0;
        for factor in &self.factors {
            match *factor {
                Factor::Constant(ref pose) => {
                    let through = |v: [f64; 3]| x * v[0] + y * v[1] + z * v[2];
                    let [a, b, c]: [[f64; 3]; 3] = pose.rotation.data.0;
                    at += through(pose.translation.into());
                    (x, y, z) = (through(a), through(b), through(c));
                }
                Factor::Shift(by) => at += x * by.x + y * by.y + z * by.z,
                Factor::Spin(direction, s, c) => spin(direction, s, c, &mut x, &mut y, &mut z),
                Factor::Shifted(from) => {
                    at += x * errors[from] + y * errors[from + 1] + z * errors[from + 2];
                }
                Factor::Turned(site, direction) => {
                    let (s, c) = sin_cos_small(errors[site]);
                    spin(direction, s, c, &mut x, &mut y, &mut z);
                }
                Factor::Turn => {
                    let (s, c) = turns[k];
                    out.axes[k] = z;
                    out.origins[k] = at;
                    (x, y) = (x * c + y * s, y * c - x * s);
                    k += 1;
                }
                Factor::Slide => {
                    out.axes[k] = z;
                    out.origins[k] = at;
                    at += z * q[k];
                    k += 1;
                }
                Factor::Skip => {
                    out.axes[k] = Vector3::zeros();
                    k += 1;
                }
                Factor::Mark(_) => {}
            }
        }
        out.tool = Pose::new(Matrix3::from_columns(&[x, y, z]), at);
    }
}

/// Turns the columns of a rotation about one of them.
#[inline]
fn spin(direction: usize, s: f64, c: f64, x: &mut Vector3<f64>, y: &mut Vector3<f64>, z: &mut Vector3<f64>) {
    let (a, b) = match direction {
        0 => (y, z),
        1 => (z, x),
        _ => (x, y),
    };
    (*a, *b) = (*a * c + *b * s, *b * c - *a * s);
}

/// `pre` and `post` of a joint, so that its motion between them is about or along z.
pub(crate) fn around_motion(chain: &Chain, id: JointId) -> (Pose, Pose) {
    let joint = chain.joint(id);
    let at_zero = joint.transform(0.0);
    let along = |axis: Vector3<f64>| {
        // Any rotation that takes z to the axis; the identity, exactly, when it is z.
        let z = Vector3::z();
        if axis == z {
            Matrix3::identity()
        } else {
            Rotation3::rotation_between(&z, &axis)
                .map_or(Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)), |r| r.into_inner())
        }
    };
    match joint.placement {
        _ if joint.kind == JointKind::Fixed => (at_zero, Pose::IDENTITY),
        Placement::Dh { .. } => (Pose::IDENTITY, at_zero),
        Placement::Mdh { .. } => (at_zero, Pose::IDENTITY),
        Placement::Origin { axis, .. } => {
            let turned = Pose::new(along(axis.into_inner()), Vector3::zeros());
            (at_zero * turned, turned.inverse())
        }
    }
}

/// Factors while they are collected.
struct Factors {
    factors: Vec<Factor>,
    pending: Pose,
}

impl Factors {
    fn constant(&mut self, pose: &Pose) {
        self.pending = self.pending * *pose;
    }

    fn errors(&mut self, frame: usize, errors: &[f64], moves: &[bool]) {
        let moving = |k: usize| moves.get(6 * frame + k).copied().unwrap_or(false);
        let error = |k: usize| errors.get(6 * frame + k).copied().unwrap_or(0.0);
        if !(0..6).any(moving) {
            if (0..6).any(|k| error(k) != 0.0) {
                self.constant(&error_matrix(&std::array::from_fn(error)));
            }
            return;
        }
        if (0..3).any(moving) {
            self.push(Factor::Shifted(6 * frame));
        } else {
            self.constant(&Pose::new(Matrix3::identity(), Vector3::new(error(0), error(1), error(2))));
        }
        for k in [4, 5, 3] {
            if moving(k) {
                self.push(Factor::Turned(6 * frame + k, k - 3));
            } else {
                self.constant(&Pose::rot(k - 3, error(k)));
            }
        }
    }

    /// Relative to what is pending, so that constants on either side of a mark remain one.
    fn marks(&mut self, frame: usize, marks: &[Marked]) {
        for (_, mark) in marks.iter().filter(|(at, _)| at.0 == frame) {
            let (point, direction) =
                (self.pending.apply(&mark.point), self.pending.rotation * mark.direction);
            self.factors.push(Factor::Mark(Mark { point, direction, ..*mark }));
        }
    }

    fn push(&mut self, factor: Factor) {
        self.flush();
        self.factors.push(factor);
    }

    fn flush(&mut self) {
        let pose = std::mem::take(&mut self.pending);
        let moves = pose.translation != Vector3::zeros();
        if pose.rotation == Matrix3::identity() {
            if moves {
                self.factors.push(Factor::Shift(pose.translation));
            }
            return;
        }
        // About a coordinate axis: its column and row are those of the identity, exactly.
        let about = (0..3).find(|&k| {
            let e = Vector3::ith(k, 1.0);
            pose.rotation.column(k) == e && pose.rotation.row(k).transpose() == e
        });
        match about {
            Some(k) => {
                if moves {
                    self.factors.push(Factor::Shift(pose.translation));
                }
                let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                self.factors.push(Factor::Spin(k, pose.rotation[(b, a)], pose.rotation[(a, a)]));
            }
            None => self.factors.push(Factor::Constant(pose)),
        }
    }
}

/// Sine and cosine; to the last digit below 0.03 rad by their series.
#[inline]
fn sin_cos_small(x: f64) -> (f64, f64) {
    if x.abs() < 0.03 {
        let t = x * x;
        let s = x * (1.0 - t * (1.0 / 6.0) * (1.0 - t * (1.0 / 20.0) * (1.0 - t * (1.0 / 42.0))));
        let c =
            1.0 - t * 0.5 * (1.0 - t * (1.0 / 12.0) * (1.0 - t * (1.0 / 30.0) * (1.0 - t * (1.0 / 56.0))));
        (s, c)
    } else {
        sin_cos(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::{GeneralizedErrors, RealPosture};
    use truepose_kinematics::{Conditions, PostureBuffer, joint_jacobian, samples};

    fn draw(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    #[test]
    fn stands_where_the_models_own_frames_say() {
        let mut state = 7;
        for chain in samples::all() {
            for round in 0..12 {
                let frames = chain.frames().len();
                let moves: Vec<bool> = (0..6 * frames).map(|_| round > 3 && draw(&mut state) > 0.0).collect();
                let size = [0.0, 1e-4, 2e-2, 0.5][round % 4];
                let errors: Vec<f64> = (0..6 * frames).map(|_| size * draw(&mut state)).collect();
                let q: Vec<f64> = chain.movable().iter().map(|_| 2.0 * draw(&mut state)).collect();

                let conditions = Conditions::at(&chain, &q);
                let mut buffer = PostureBuffer::new(&chain);
                let nominal = buffer.update(&chain, &conditions);
                let mut generalized = GeneralizedErrors::zero(&chain);
                for (index, &value) in errors.iter().enumerate() {
                    generalized.add(chain.site_at(index), value);
                }
                let mut real = RealPosture::new(&chain);
                real.update(&nominal, &generalized);

                let mut at = Reached::nowhere();
                Arm::to_tool(&chain, ToolId::FIRST, &errors, &moves).reach(
                    &q,
                    nominal.turns(),
                    &errors,
                    &mut at,
                );
                assert!((at.tool.rotation - real.tool().rotation).amax() < 1e-14, "{}", chain.name());
                assert!((at.tool.translation - real.tool().translation).amax() < 1e-14, "{}", chain.name());
                if round == 0 {
                    let jacobian = joint_jacobian(&nominal, &at.tool.translation);
                    for k in 0..q.len() {
                        let turn = jacobian.fixed_view::<3, 1>(3, k);
                        let lever = if turn.norm() > 0.0 {
                            at.axes[k].cross(&(at.tool.translation - at.origins[k]))
                        } else {
                            at.axes[k]
                        };
                        assert!((lever - jacobian.fixed_view::<3, 1>(0, k)).norm() < 1e-13);
                        assert!(turn.norm() < 0.5 || (turn - at.axes[k]).norm() < 1e-14);
                    }
                }
            }
        }
    }

    #[test]
    fn constants_are_multiplied_out() {
        let chain = samples::ur10();
        let frames = chain.frames().len();
        let arm = Arm::to_tool(&chain, ToolId::FIRST, &vec![1e-3; 6 * frames], &vec![false; 6 * frames]);
        assert_eq!(arm.factors.len(), 6 + 7);
        // A frame that yields about z costs a turn of two columns on either side of one more turn.
        let moves: Vec<bool> = (0..6 * frames).map(|k| k == 6 + 5).collect();
        let arm = Arm::to_tool(&chain, ToolId::FIRST, &vec![1e-3; 6 * frames], &moves);
        assert_eq!(arm.factors.len(), 6 + 7 + 2);
    }

    #[test]
    fn short_series_are_exact() {
        for k in -300..=300 {
            let x = f64::from(k) * 1e-4;
            let (s, c) = sin_cos_small(x);
            assert!((s - x.sin()).abs() <= f64::EPSILON * x.abs(), "{x}");
            assert!((c - x.cos()).abs() <= f64::EPSILON, "{x}");
        }
    }
}
