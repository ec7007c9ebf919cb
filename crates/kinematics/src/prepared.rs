//! A joint with its constants worked out: its transform costs a few products, and no sine but that of its variable.
//!
//! ```text
//! dh       R = [ c −s cα  s sα ; s c cα −c sα ; 0 sα cα ],   t = [ a c, a s, d ]             s, c of θ + q
//! mdh      R = [ c −s 0 ; s cα c cα −sα ; s sα c sα cα ],     t = [ a, −sα d, cα d ]
//! origin   columns of the pose turned into one another, or the pose moved along its axis
//! ```
//!
//! The sine and cosine of θ + q follow from those of q, which every user of a posture shares.

use crate::pose::sin_cos_exact;
use crate::{Joint, JointKind, Placement, Pose, rotation_vector};
use nalgebra::{Matrix3, Unit, Vector3};

/// `A_i` as a function of q and its sine and cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PreparedJoint {
    Fixed(Pose),
    Dh {
        theta: (f64, f64),
        d: f64,
        a: f64,
        alpha: (f64, f64),
    },
    Mdh {
        theta: (f64, f64),
        d: f64,
        a: f64,
        alpha: (f64, f64),
    },
    /// About a coordinate axis, on either side.
    Turn {
        pose: Pose,
        direction: usize,
        sign: f64,
    },
    /// About any axis.
    Skew {
        pose: Pose,
        axis: Unit<Vector3<f64>>,
    },
    Slide {
        pose: Pose,
        along: Vector3<f64>,
    },
}

impl Joint {
    /// The nominal transform `A_i(q)`; q in rad or m, ignored by a fixed joint.
    pub fn transform(&self, q: f64) -> Pose {
        PreparedJoint::of(self).transform(q, sin_cos_exact(q))
    }
}

impl PreparedJoint {
    pub fn of(joint: &Joint) -> Self {
        let turns = joint.kind == JointKind::Revolute;
        match joint.placement {
            Placement::Dh { theta, d, a, alpha } => {
                let made =
                    PreparedJoint::Dh { theta: sin_cos_exact(theta), d, a, alpha: sin_cos_exact(alpha) };
                made.held(joint.kind, Vector3::z())
            }
            Placement::Mdh { alpha, a, theta, d } => {
                let made =
                    PreparedJoint::Mdh { theta: sin_cos_exact(theta), d, a, alpha: sin_cos_exact(alpha) };
                let (sine, cosine) = sin_cos_exact(alpha);
                made.held(joint.kind, Vector3::new(0.0, -sine, cosine))
            }
            Placement::Origin { pose, axis } if turns => match coordinate_axis(&axis) {
                Some((direction, sign)) => PreparedJoint::Turn { pose, direction, sign },
                None => PreparedJoint::Skew { pose, axis },
            },
            Placement::Origin { pose, axis } if joint.kind == JointKind::Prismatic => {
                PreparedJoint::Slide { pose, along: pose.rotation * axis.into_inner() }
            }
            Placement::Origin { pose, .. } => PreparedJoint::Fixed(pose),
        }
    }

    /// A row of a table as it is for a turn; for the others its pose at zero, which does not move or slides along.
    fn held(self, kind: JointKind, along: Vector3<f64>) -> Self {
        let pose = self.transform(0.0, (0.0, 1.0));
        match kind {
            JointKind::Revolute => self,
            JointKind::Prismatic => PreparedJoint::Slide { pose, along },
            JointKind::Fixed => PreparedJoint::Fixed(pose),
        }
    }

    /// The transform at q (rad or m), given its sine and cosine.
    #[inline]
    pub fn transform(&self, q: f64, (sine, cosine): (f64, f64)) -> Pose {
        match *self {
            PreparedJoint::Fixed(pose) => pose,
            PreparedJoint::Dh { theta, d, a, alpha: (sa, ca) } => {
                let (s, c) = added(theta, (sine, cosine));
                Pose::new(
                    Matrix3::new(c, -s * ca, s * sa, s, c * ca, -c * sa, 0.0, sa, ca),
                    Vector3::new(a * c, a * s, d),
                )
            }
            PreparedJoint::Mdh { theta, d, a, alpha: (sa, ca) } => {
                let (s, c) = added(theta, (sine, cosine));
                Pose::new(
                    Matrix3::new(c, -s, 0.0, s * ca, c * ca, -sa, s * sa, c * sa, ca),
                    Vector3::new(a, -sa * d, ca * d),
                )
            }
            PreparedJoint::Turn { mut pose, direction, sign } => {
                pose.rotation = turned(&pose.rotation, direction, sign * sine, cosine);
                pose
            }
            PreparedJoint::Skew { pose, axis } => {
                pose * Pose::new(rotation_vector(&axis.scale(q)), Vector3::zeros())
            }
            PreparedJoint::Slide { pose, along } => Pose::new(pose.rotation, pose.translation + along * q),
        }
    }
}

/// A rotation times one about a coordinate axis.
#[inline]
fn turned(rotation: &Matrix3<f64>, direction: usize, s: f64, c: f64) -> Matrix3<f64> {
    let (x, y, z): (Vector3<f64>, Vector3<f64>, Vector3<f64>) =
        (rotation.column(0).into(), rotation.column(1).into(), rotation.column(2).into());
    let columns = match direction {
        0 => [x, y * c + z * s, z * c - y * s],
        1 => [x * c - z * s, y, z * c + x * s],
        _ => [x * c + y * s, y * c - x * s, z],
    };
    Matrix3::from_columns(&columns)
}

/// Sine and cosine of a sum.
#[inline]
fn added((s0, c0): (f64, f64), (s, c): (f64, f64)) -> (f64, f64) {
    (s0 * c + c0 * s, c0 * c - s0 * s)
}

/// The coordinate axis (0…2) and sign that a unit vector coincides with, if it does exactly.
fn coordinate_axis(axis: &Unit<Vector3<f64>>) -> Option<(usize, f64)> {
    (0..3).find(|&k| axis[(k + 1) % 3] == 0.0 && axis[(k + 2) % 3] == 0.0).map(|k| (k, axis[k].signum()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definitions, factor by factor.
    fn by_definition(joint: &Joint, q: f64) -> Pose {
        let (turn, slide) = match joint.kind {
            JointKind::Revolute => (q, 0.0),
            JointKind::Prismatic => (0.0, q),
            JointKind::Fixed => (0.0, 0.0),
        };
        match joint.placement {
            Placement::Dh { theta, d, a, alpha } => {
                Pose::rot(2, theta + turn)
                    * Pose::trans(2, d + slide)
                    * Pose::trans(0, a)
                    * Pose::rot(0, alpha)
            }
            Placement::Mdh { alpha, a, theta, d } => {
                Pose::rot(0, alpha)
                    * Pose::trans(0, a)
                    * Pose::rot(2, theta + turn)
                    * Pose::trans(2, d + slide)
            }
            Placement::Origin { pose, axis } => {
                pose * Pose::new(rotation_vector(&axis.scale(turn)), axis.scale(slide))
            }
        }
    }

    proptest! {
        #[test]
        fn every_convention_is_what_its_definition_says(
            n in prop::array::uniform4(-3.0..3.0f64), q in -7.0..7.0f64, which in 0usize..3, sort in 0usize..6
        ) {
            let [theta, d, a, alpha] = n;
            let kind = [JointKind::Revolute, JointKind::Prismatic, JointKind::Fixed][which];
            let pose = Pose::from_xyz_rpy([a, d, 0.3], [alpha, 0.4, theta]);
            let origin = |axis: Vector3<f64>| Placement::Origin { pose, axis: Unit::new_normalize(axis) };
            let placement = match sort {
                0 => Placement::Dh { theta, d, a, alpha },
                1 => Placement::Mdh { alpha, a, theta, d },
                2 => origin(Vector3::x() * d.signum()),
                3 => origin(Vector3::y() * d.signum()),
                4 => origin(Vector3::z() * d.signum()),
                _ => origin(Vector3::new(theta, d, 0.1)),
            };
            let joint = Joint::new("j", kind, placement);
            let expected = by_definition(&joint, q);
            let prepared = PreparedJoint::of(&joint);
            for found in [joint.transform(q), prepared.transform(q, crate::sin_cos(q))] {
                prop_assert!((found.rotation - expected.rotation).amax() < 4e-15);
                prop_assert!((found.translation - expected.translation).amax() < 1e-14);
            }
        }
    }
}
