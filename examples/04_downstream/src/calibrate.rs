//! Gauss and Newton's method, written out: predict, linearise, solve, add.
//!
//! ```text
//! y − T(c) ≈ J_e Φ δc,      min ‖y − T(c) − J_e Φ δc‖²,      c ← c + δc
//! ```

use std::error::Error;
use truepose_errormodel::{AnyEffect, ErrorModel, FittedModel, Schema};
use truepose_kinematics::nalgebra::{DMatrix, DVector, Vector3};
use truepose_kinematics::{Chain, Conditions};
use truepose_solvers::{LeastSquares, PivotedQr, Solver};

/// Joint values (rad, m) and the position that was measured there, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement {
    /// As commanded.
    pub joints: [f64; 3],
    /// Of the tool.
    pub position: [f64; 3],
}

/// From a millimetre each iteration leaves its square over the robot's size, which is rounding after three.
const ITERATIONS: usize = 4;

/// Fits the coefficients of these effects. Directions that the data cannot identify stay at zero: the solver reveals the rank.
///
/// # Errors
/// When the effects do not fit the robot, or the measurements are not finite.
pub fn calibrate(
    chain: &Chain,
    effects: Vec<Box<dyn AnyEffect>>,
    measured: &[Measurement],
) -> Result<(FittedModel, usize), Box<dyn Error>> {
    let model = ErrorModel::new(chain.clone(), effects)?;
    let scale: Vec<f64> = model.columns().iter().map(|column| column.scale).collect();
    let p = scale.len();
    let (mut c, mut rank) = (vec![0.0; p], 0);
    for _ in 0..ITERATIONS {
        let fitted = FittedModel::new(model.clone(), c.clone(), DMatrix::zeros(p, p))?;
        let mut predictor = fitted.bind(&Schema::default())?;
        let mut a = DMatrix::zeros(3 * measured.len(), p);
        let mut y = DVector::zeros(3 * measured.len());
        for (k, row) in measured.iter().enumerate() {
            let conditions = Conditions::at(chain, &row.joints);
            let predicted = predictor.predict(&conditions, None).translation;
            y.fixed_rows_mut::<3>(3 * k).copy_from(&(Vector3::from(row.position) - predicted));
            let moved = predictor.sensitivity(&conditions, None);
            a.view_mut((3 * k, 0), (3, p)).copy_from(&moved.rows(0, 3));
        }
        let solution = PivotedQr::default().solve(&LeastSquares::new(&a, &y).with_scale(&scale))?;
        rank = solution.rank;
        c.iter_mut().zip(&solution.x).for_each(|(c, step)| *c += step);
    }
    Ok((FittedModel::new(model, c, DMatrix::zeros(p, p))?, rank))
}

/// RMS distance between a model's positions and measured ones, m.
///
/// # Errors
/// When the model asks for signals that joint values do not give.
pub fn rms(fitted: &FittedModel, measured: &[Measurement]) -> Result<f64, Box<dyn Error>> {
    let mut predictor = fitted.bind(&Schema::default())?;
    let mut sum = 0.0;
    for row in measured {
        let conditions = Conditions::at(fitted.chain(), &row.joints);
        sum +=
            (Vector3::from(row.position) - predictor.predict(&conditions, None).translation).norm_squared();
    }
    Ok((sum / measured.len().max(1) as f64).sqrt())
}
