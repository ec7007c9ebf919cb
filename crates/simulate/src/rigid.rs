//! Rigid transforms of the plant: unit quaternions and translations, made from a chain's numbers.
//!
//! The model multiplies rotation matrices; the plant composes quaternions, splits each joint into what
//! stands still before its axis, its motion, and what moves with it, and takes rotation vectors for small
//! displacements where the model takes a product of three rotations. The two have no code in common.
//!
//! ```text
//!          before            motion(q)            after
//! dh    turn  1            Rz(θ + q)         Tz(d) Tx(a) Rx(α)
//!       slide Rz(θ) Tz(d)  Tz(q)             Tx(a) Rx(α)
//! mdh   turn  Rx(α) Tx(a)  Rz(θ + q)         Tz(d)
//!       slide Rx(α) Tx(a) Rz(θ) Tz(d)  Tz(q)  1
//! origin      pose         about or along axis  1
//! ```

use nalgebra::{Isometry3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};
use truepose_kinematics::{Joint, JointKind, Placement, Pose};

/// A rigid transform.
pub(crate) type Rigid = Isometry3<f64>;

/// The transform that a pose describes.
pub(crate) fn from_pose(pose: &Pose) -> Rigid {
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(pose.rotation));
    Rigid::from_parts(Translation3::from(pose.translation), rotation)
}

/// The pose of a transform.
pub(crate) fn to_pose(rigid: &Rigid) -> Pose {
    Pose::new(rigid.rotation.to_rotation_matrix().into_inner(), rigid.translation.vector)
}

/// A small displacement `[tx ty tz rx ry rz]`: the rotation vector and the translation, m and rad.
pub(crate) fn displaced(by: &[f64; 6]) -> Rigid {
    Rigid::new(Vector3::new(by[0], by[1], by[2]), Vector3::new(by[3], by[4], by[5]))
}

/// The displacement `by` of everything behind a point, which itself moves by the translation only.
pub(crate) fn displaced_at(point: &Vector3<f64>, by: &[f64; 6]) -> Rigid {
    Translation3::from(*point) * displaced(by) * Translation3::from(-*point)
}

/// A joint, taken apart at its axis.
#[derive(Debug, Clone)]
pub(crate) struct TakenApart {
    /// Previous frame → axis, at rest.
    pub before: Rigid,
    /// Axis in the axes of the frame behind `before`.
    pub axis: Unit<Vector3<f64>>,
    /// Turning, sliding, or neither.
    pub kind: JointKind,
    /// Added to the variable of a turn, rad.
    pub offset: f64,
    /// Axis → this joint's frame.
    pub after: Rigid,
}

impl TakenApart {
    /// Takes a joint apart.
    pub fn of(joint: &Joint) -> Self {
        let z = Vector3::z_axis();
        let turn_z = |angle: f64| Rigid::rotation(Vector3::z() * angle);
        let turn_x = |angle: f64| Rigid::rotation(Vector3::x() * angle);
        let slide = |x: f64, z: f64| Rigid::translation(x, 0.0, z);
        let (before, axis, offset, after) = match joint.placement {
            Placement::Dh { theta, d, a, alpha } => match joint.kind {
                JointKind::Revolute => (Rigid::identity(), z, theta, slide(a, d) * turn_x(alpha)),
                _ => (turn_z(theta) * slide(0.0, d), z, 0.0, slide(a, 0.0) * turn_x(alpha)),
            },
            Placement::Mdh { alpha, a, theta, d } => match joint.kind {
                JointKind::Revolute => (turn_x(alpha) * slide(a, 0.0), z, theta, slide(0.0, d)),
                _ => {
                    (turn_x(alpha) * slide(a, 0.0) * turn_z(theta) * slide(0.0, d), z, 0.0, Rigid::identity())
                }
            },
            Placement::Origin { pose, axis } => (from_pose(&pose), axis, 0.0, Rigid::identity()),
        };
        TakenApart { before, axis, kind: joint.kind, offset, after }
    }

    /// The motion at this value of the variable, rad or m.
    pub fn motion(&self, q: f64) -> Rigid {
        match self.kind {
            JointKind::Revolute => Rigid::rotation(self.axis.into_inner() * (self.offset + q)),
            JointKind::Prismatic => Rigid::from(Translation3::from(self.axis.into_inner() * q)),
            JointKind::Fixed => Rigid::identity(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_displacement_at_a_point_moves_that_point_by_its_translation() {
        let point = Vector3::new(0.3, -0.2, 0.7);
        let by = [1e-3, 2e-3, -1e-3, 0.01, -0.02, 0.03];
        let moved = displaced_at(&point, &by) * nalgebra::Point3::from(point);
        assert!((moved.coords - point - Vector3::new(1e-3, 2e-3, -1e-3)).norm() < 1e-15);
    }

    #[test]
    fn a_pose_comes_back() {
        let pose =
            Pose::new(*Rotation3::new(Vector3::new(0.4, -1.2, 2.0)).matrix(), Vector3::new(1.0, 2.0, 3.0));
        let back = to_pose(&from_pose(&pose));
        assert!((back.rotation - pose.rotation).amax() < 1e-15);
        assert!((back.translation - pose.translation).amax() < 1e-15);
    }
}
