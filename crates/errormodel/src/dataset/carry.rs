//! The same measurements seen from another frame.

use super::table::Dataset;
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::Pose;

impl Dataset {
    /// Moves everything that was measured: positions, orientations and their standard deviations into the frame `x`, new ← old. A row of
    /// which only some components of the position were measured keeps none, since they have no axes there.
    pub fn carry(&mut self, x: &Pose) {
        for row in 0..self.len() {
            self.carry_row(row, x);
        }
    }

    /// As [`Dataset::carry`], one row.
    pub fn carry_row(&mut self, row: usize, x: &Pose) {
        if self.position[row].iter().any(|v| !v.is_nan()) {
            self.position[row] = x.apply(&self.measured_position(row)).into();
        }
        if let Some(measured) = self.measured_rotation(row) {
            self.orientation[row] = Some(Pose::new(x.rotation * measured, Vector3::zeros()).quaternion());
        }
        self.position_sd[row] = turned(&x.rotation, self.position_sd[row]);
        self.orientation_sd[row] = turned(&x.rotation, self.orientation_sd[row]);
    }
}

/// Standard deviations along the new axes: √diag(R diag(σ²) Rᵀ); equal ones stay to the bit.
fn turned(rotation: &Matrix3<f64>, sd: [f64; 3]) -> [f64; 3] {
    if sd.iter().any(|v| v.is_nan()) || sd.iter().all(|v| v.to_bits() == sd[0].to_bits()) {
        return sd;
    }
    std::array::from_fn(|k| (0..3).map(|j| (rotation[(k, j)] * sd[j]).powi(2)).sum::<f64>().sqrt())
}
