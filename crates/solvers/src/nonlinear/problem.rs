//! The nonlinear least-squares problem and its solution.
//!
//! minimise ½ ‖r(x)‖²,  J = ∂r/∂x
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | x | unknowns | p | each its own |
//! | r | residual: computed minus observed, whitened | m | 1 |
//! | J | Jacobian | m × p | 1 per unit of x_j |

use crate::Status;
use crate::accumulator::Factor;
use nalgebra::{DMatrix, DVector};

/// A residual and its Jacobian. A residual that cannot be evaluated somewhere is NaN there: the step is then shortened.
pub trait NonlinearLeastSquares {
    /// Rows m and unknowns p.
    fn size(&self) -> (usize, usize);
    /// Writes r(x), m entries.
    fn residual(&self, x: &[f64], out: &mut DVector<f64>);
    /// Writes J(x), m × p.
    fn jacobian(&self, x: &[f64], out: &mut DMatrix<f64>);
}

impl<P: NonlinearLeastSquares + ?Sized> NonlinearLeastSquares for &P {
    fn size(&self) -> (usize, usize) {
        (**self).size()
    }
    fn residual(&self, x: &[f64], out: &mut DVector<f64>) {
        (**self).residual(x, out);
    }
    fn jacobian(&self, x: &[f64], out: &mut DMatrix<f64>) {
        (**self).jacobian(x, out);
    }
}

/// A problem made of two closures.
#[derive(Debug, Clone)]
pub struct FromClosures<R, J> {
    size: (usize, usize),
    residual: R,
    jacobian: J,
}

impl<R, J> FromClosures<R, J>
where
    R: Fn(&[f64], &mut DVector<f64>),
    J: Fn(&[f64], &mut DMatrix<f64>),
{
    /// `rows` residuals of `unknowns` unknowns.
    pub fn new(rows: usize, unknowns: usize, residual: R, jacobian: J) -> Self {
        Self { size: (rows, unknowns), residual, jacobian }
    }
}

impl<R, J> NonlinearLeastSquares for FromClosures<R, J>
where
    R: Fn(&[f64], &mut DVector<f64>),
    J: Fn(&[f64], &mut DMatrix<f64>),
{
    fn size(&self) -> (usize, usize) {
        self.size
    }
    fn residual(&self, x: &[f64], out: &mut DVector<f64>) {
        (self.residual)(x, out);
    }
    fn jacobian(&self, x: &[f64], out: &mut DMatrix<f64>) {
        (self.jacobian)(x, out);
    }
}

/// Where a nonlinear fit ended.
#[derive(Debug, Clone, PartialEq)]
pub struct NonlinearSolution {
    /// The unknowns.
    pub x: DVector<f64>,
    /// How it ended.
    pub status: Status,
    /// ‖r(x)‖.
    pub residual_norm: f64,
    /// Largest |J_jᵀ r| / (‖J_j‖ ‖r‖) at x.
    pub gradient: f64,
    /// Steps taken.
    pub iterations: usize,
    /// Evaluations of the residual.
    pub evaluations: usize,
    /// Evaluations of the Jacobian.
    pub jacobians: usize,
    /// Triangle of [J | −r] at x: rank, null space and covariance follow from it.
    pub factor: Factor,
}

/// Largest difference between the Jacobian and central differences of the residual at `x`, relative to the norm of each
/// column. For tests of problems.
pub fn check_jacobian(problem: &dyn NonlinearLeastSquares, x: &[f64], steps: &[f64]) -> f64 {
    let (m, p) = problem.size();
    let mut j = DMatrix::zeros(m, p);
    problem.jacobian(x, &mut j);
    let mut worst = 0.0_f64;
    for k in 0..p {
        let at = |step: f64| {
            let mut moved = x.to_vec();
            moved[k] += step;
            let mut r = DVector::zeros(m);
            problem.residual(&moved, &mut r);
            r
        };
        // Fourth order.
        let h = steps[k];
        let slope = ((at(h) - at(-h)) * 8.0 - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
        let column = j.column(k);
        worst = worst.max((slope - column).norm() / column.norm().max(f64::MIN_POSITIVE));
    }
    worst
}
