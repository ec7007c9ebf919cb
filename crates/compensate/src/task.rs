//! Error of the pose, and its derivative with respect to the joints.
//!
//! ```text
//! e = [ (p_d − p)/L ; log(R_d Rᵀ) ]         J_k = [ z_k × (p − o_k)/L ; z_k ]  or, for a slide,  [ z_k ; 0 ]
//! ```
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | p_d, R_d | `position`, `rotation` | 3, 3×3 | m | measurement |
//! | L | `length` | 1 | m | the robot's characteristic length: makes metres and radians comparable |
//! | e | [`Gap::error`] | 6 | 1 | measurement |
//! | J | [`Columns`] | 6 × joints | 1 per rad, or per L of travel | measurement |

use crate::arm::{Arm, Reached};
use crate::command::MOST;
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{TargetId, rotation_log};

/// What is to be reached.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Task {
    pub position: Vector3<f64>,
    /// None: only the position counts.
    pub rotation: Option<Matrix3<f64>>,
    pub target: Option<TargetId>,
    pub length: f64,
    pub position_tolerance: f64,
    pub orientation_tolerance: f64,
}

/// Derivative with respect to each joint.
pub(crate) type Columns = [[f64; 6]; MOST];

/// How far away it is from one configuration.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gap {
    pub error: [f64; 6],
    /// |e|².
    pub cost: f64,
}

impl Gap {
    pub fn position(&self, length: f64) -> f64 {
        length * norm(&self.error[..3])
    }

    pub fn orientation(&self) -> f64 {
        norm(&self.error[3..])
    }
}

impl Task {
    /// The rows of e and J that count.
    pub fn rows(&self) -> usize {
        if self.rotation.is_some() { 6 } else { 3 }
    }

    /// The gap of a point of the tool, which is left in `at`.
    #[inline]
    pub fn gap(&self, at: &mut Reached, point_in_tool: &Vector3<f64>) -> Gap {
        at.point = at.tool.apply(point_in_tool);
        let away = (self.position - at.point) * (1.0 / self.length);
        let turn = self.rotation.map_or(Vector3::zeros(), |wanted| turn_between(&at.tool.rotation, &wanted));
        Gap {
            error: [away.x, away.y, away.z, turn.x, turn.y, turn.z],
            cost: away.norm_squared() + turn.norm_squared(),
        }
    }

    /// Fills J, of the real axes, for the point of the last gap.
    #[inline]
    pub fn columns(&self, arm: &Arm, at: &Reached, columns: &mut Columns) {
        let per_length = 1.0 / self.length;
        for (k, column) in columns.iter_mut().enumerate().take(arm.joints()) {
            let z = at.axes[k];
            *column = if arm.slides(k) {
                [z.x, z.y, z.z, 0.0, 0.0, 0.0]
            } else {
                let lever = z.cross(&(at.point - at.origins[k])) * per_length;
                [lever.x, lever.y, lever.z, z.x, z.y, z.z]
            };
        }
    }

    /// True when a step with the J from in front of a step of this length is expected to remove the error: J has changed by about
    /// that much of itself.
    pub fn foretells(&self, gap: &Gap, length: f64) -> bool {
        gap.position(self.length) * length <= 0.2 * self.position_tolerance
            && gap.orientation() * length <= 0.2 * self.orientation_tolerance
    }

    /// True when the gap is within the tolerances.
    pub fn reached(&self, gap: &Gap) -> bool {
        gap.position(self.length) <= self.position_tolerance
            && (self.rotation.is_none() || gap.orientation() <= self.orientation_tolerance)
    }
}

/// Rotation vector, in the outer axes, that takes one orientation to another.
#[inline]
fn turn_between(from: &Matrix3<f64>, to: &Matrix3<f64>) -> Vector3<f64> {
    let column = |m: &Matrix3<f64>, k: usize| Vector3::from(m.column(k));
    // Twice the sine times the axis; below a quarter of a degree a short series is exact to the last digits.
    let mut v = Vector3::zeros();
    let mut trace = 0.0;
    for k in 0..3 {
        let (a, b) = (column(from, k), column(to, k));
        v += a.cross(&b);
        trace += a.dot(&b);
    }
    v *= 0.5;
    let s2 = v.norm_squared();
    if s2 < 2e-5 && trace > 1.0 {
        v * (1.0 + s2 * (1.0 / 6.0 + s2 * 0.075))
    } else {
        rotation_log(&(to * from.transpose()))
    }
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::rotation_vector;

    #[test]
    fn turns_are_exact_at_every_size() {
        let start = rotation_vector(&Vector3::new(0.3, -1.0, 0.4));
        for size in [1e-12, 1e-6, 1e-3, 4e-3, 5e-3, 0.3, 3.0] {
            let turn = Vector3::new(0.6, -0.48, 0.64) * size;
            let found = turn_between(&start, &(rotation_vector(&turn) * start));
            assert!((found - turn).norm() < 1e-15 + 1e-12 * size, "{size}: {}", (found - turn).norm());
        }
    }
}
