//! Link frames where the makers of arms put them, for a description that has others: rows of Denavit and Hartenberg of nearly parallel axes have
//! frames hundreds of metres away.
//!
//! ```text
//! p_k = the point of axis k nearest to axis k+1;  where these are nearly parallel, nearest to p_{k−1};  of the last axis, nearest to the flange
//! R_k = the smallest turn of R_{k−1} that has the joint's axis where it is at zero,  R_0 = 1
//! ```
//!
//! Such are the frames in the files of Universal Robots, Franka and UFACTORY.

use nalgebra::{Unit, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use truepose_kinematics::Pose;

/// Sine of the angle below which the nearest points of two axes are far away.
const PARALLEL: f64 = 0.2;

/// A joint's axis at zero, in the robot's base.
pub(super) struct Line {
    pub point: Vector3<f64>,
    pub direction: Unit<Vector3<f64>>,
}

impl Line {
    fn nearest(&self, to: &Vector3<f64>) -> Vector3<f64> {
        self.point + self.direction.into_inner() * self.direction.dot(&(to - self.point))
    }

    /// The point nearest to another line; none where the lines are nearly parallel.
    fn foot(&self, other: &Line) -> Option<Vector3<f64>> {
        let across = self.direction.cross(&other.direction);
        let along = (other.point - self.point).cross(&other.direction).dot(&across) / across.norm_squared();
        (across.norm() > PARALLEL).then(|| self.point + self.direction.into_inner() * along)
    }
}

/// The frames, in the robot's base at zero; `axes` are those of the file's joints in their own frames, and the last frame is at the flange where one is
/// given.
pub(super) fn link_frames(
    lines: &[Line],
    axes: &[Unit<Vector3<f64>>],
    flange: Option<&Vector3<f64>>,
) -> Vec<Pose> {
    let mut frame = Pose::IDENTITY;
    let mut frames = Vec::with_capacity(lines.len());
    for (k, (line, axis)) in lines.iter().zip(axes).enumerate() {
        let place = match (lines.get(k + 1), flange) {
            (Some(next), _) => line.foot(next),
            (None, Some(flange)) => Some(line.nearest(flange)),
            (None, None) => k.checked_sub(1).and_then(|before| line.foot(&lines[before])),
        };
        let turn = shortest(&(frame.rotation * axis.into_inner()), &line.direction);
        let place = place.unwrap_or_else(|| line.nearest(&frame.translation));
        frame = Pose::new(turn.to_rotation_matrix().matrix() * frame.rotation, place);
        frames.push(frame);
    }
    frames
}

/// The smallest turn from one direction to another; half a turn about x, or y, where they are opposite.
pub(super) fn shortest(from: &Vector3<f64>, to: &Unit<Vector3<f64>>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(from, to).unwrap_or_else(|| {
        let least = if from.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        UnitQuaternion::from_axis_angle(&Unit::new_normalize(least - from * from.dot(&least)), PI)
    })
}
