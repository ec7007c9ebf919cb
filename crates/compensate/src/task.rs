//! How far the robot is from where it should be, and how its joints change that.
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
//! | J | [`Gap::columns`] | 6 × joints | 1 per rad, or per L of travel | measurement |

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

/// How far away it is from one configuration.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gap {
    pub error: [f64; 6],
    pub columns: [[f64; 6]; MOST],
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

    /// The gap, without J.
    pub fn gap(&self, at: &Reached, point_in_tool: &Vector3<f64>, gap: &mut Gap) -> Vector3<f64> {
        let point = at.tool.apply(point_in_tool);
        let away = (self.position - point) / self.length;
        let turn = self.rotation.map_or(Vector3::zeros(), |wanted| turn_between(&at.tool.rotation, &wanted));
        gap.error = [away.x, away.y, away.z, turn.x, turn.y, turn.z];
        gap.cost = away.norm_squared() + turn.norm_squared();
        point
    }

    /// Fills J, of the real axes, for a point in the measurement frame.
    pub fn columns(&self, arm: &Arm, at: &Reached, point: &Vector3<f64>, gap: &mut Gap) {
        let per_length = 1.0 / self.length;
        for k in 0..arm.joints() {
            let z = at.axes[k];
            gap.columns[k] = if arm.slides(k) {
                [z.x, z.y, z.z, 0.0, 0.0, 0.0]
            } else {
                let lever = z.cross(&(point - at.origins[k])) * per_length;
                [lever.x, lever.y, lever.z, z.x, z.y, z.z]
            };
        }
    }

    /// True when the gap is within the tolerances.
    pub fn reached(&self, gap: &Gap) -> bool {
        gap.position(self.length) <= self.position_tolerance
            && (self.rotation.is_none() || gap.orientation() <= self.orientation_tolerance)
    }
}

/// Rotation vector, in the outer axes, that takes one orientation to another.
fn turn_between(from: &Matrix3<f64>, to: &Matrix3<f64>) -> Vector3<f64> {
    let d = to * from.transpose();
    // Twice the sine times the axis; below a quarter of a degree a short series is exact to the last digits.
    let v = Vector3::new(d[(2, 1)] - d[(1, 2)], d[(0, 2)] - d[(2, 0)], d[(1, 0)] - d[(0, 1)]) * 0.5;
    let s2 = v.norm_squared();
    if s2 < 2e-5 && d.trace() > 1.0 { v * (1.0 + s2 * (1.0 / 6.0 + s2 * 0.075)) } else { rotation_log(&d) }
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
