//! How a desired position leans on the fit where it is relative to something that the robot itself, or a positioner, has placed.
//!
//! ```text
//! cov(p − d) = (J_p − J_d) C (J_p − J_d)ᵀ + Q          p: where the robot really comes,  d: where it is to come
//! ```
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | J_d | `rows`: d by the coefficients | 3 × p | m per coefficient |
//! | Q | `noise`: what touching, or the positioner, scatters | 3 × 3 | m² |
//! | C | covariance of the coefficients | p × p | |
//!
//! Near the points at which a frame was touched both are wrong together, and the difference is less uncertain than either.

use truepose_errormodel::FittedModel;
use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::{DMatrix, Matrix3, Vector3};

/// Steps of differences, m or rad: frames of centimetres to metres are linear over them.
pub(super) const STEP: f64 = 1e-6;

/// Of one desired position.
#[derive(Debug, Clone)]
pub(super) struct Lean {
    pub(super) rows: DMatrix<f64>,
    pub(super) noise: Matrix3<f64>,
}

impl Lean {
    pub(super) fn none(columns: usize) -> Lean {
        Lean { rows: DMatrix::zeros(3, columns), noise: Matrix3::zeros() }
    }

    /// Adds an input on which the position depends by this matrix.
    pub(super) fn add(&mut self, by: &Matrix3<f64>, input: &Lean) {
        self.rows += by * &input.rows;
        self.noise += by * input.noise * by.transpose();
    }

    /// Covariance of the distance from where the robot comes, whose position has these rows.
    pub(super) fn covariance(&self, fitted: &FittedModel, robot: &DMatrix<f64>) -> Matrix3<f64> {
        let difference = robot.rows(0, 3) - &self.rows;
        let spread = &difference * fitted.covariance() * difference.transpose();
        Matrix3::from_iterator(spread.iter().copied()) + self.noise
    }
}

/// A pose of the real robot's tool, and how it depends on the coefficients: 6 × p, measurement frame.
#[derive(Debug, Clone)]
pub(super) struct Seen {
    pub(super) pose: Pose,
    pub(super) rows: DMatrix<f64>,
}

impl Seen {
    /// The same of something that moves with it, at this pose.
    pub(super) fn moved(&self, pose: &Pose) -> Seen {
        let mut rows = self.rows.clone();
        rows.rows_mut(0, 3).copy_from(&self.point(&pose.translation, 0.0).rows);
        Seen { pose: *pose, rows }
    }

    /// The rotation of this pose, by the coefficients: 3 × p.
    pub(super) fn turning(&self) -> DMatrix<f64> {
        self.rows.rows(3, 3).into_owned()
    }

    /// A point that moves with it, at a place in the measurement frame; each axis scatters by `sd`, m.
    pub(super) fn point(&self, at: &Vector3<f64>, sd: f64) -> Lean {
        let lever = at - self.pose.translation;
        let mut rows = self.rows.rows(0, 3).into_owned();
        rows -= lever.cross_matrix() * self.rows.rows(3, 3);
        Lean { rows, noise: Matrix3::identity() * sd.powi(2) }
    }
}

/// The derivative of a place by another one, by differences.
pub(super) fn derivative(of: impl Fn(&Vector3<f64>) -> Option<Vector3<f64>>) -> Option<Matrix3<f64>> {
    let mut all = Matrix3::zeros();
    for axis in 0..3 {
        let mut step = Vector3::zeros();
        step[axis] = STEP;
        all.set_column(axis, &((of(&step)? - of(&-step)?) / (2.0 * STEP)));
    }
    Some(all)
}
