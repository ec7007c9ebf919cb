//! argmin's trust region and L-BFGS on the same problem, for comparison.
//!
//! Both form what Levenberg-Marquardt avoids: JᵀJ, or nothing but the gradient. Neither of argmin's two ends on the relative
//! gradient of a least-squares problem, so a wrapper does that.

use super::bridge::{At, Bridge, Until};
use super::{NonlinearLeastSquares, NonlinearSolution};
use crate::{SolveError, Status};
use argmin::core::Executor;
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use argmin::solver::trustregion::{Steihaug, TrustRegion as ArgminTrustRegion};

/// argmin's trust region with Steihaug's conjugate gradients on the Gauss-Newton Hessian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrustRegion {
    /// Largest number of iterations.
    pub max_iterations: usize,
    /// Done when every |J_jᵀ r| / (‖J_j‖ ‖r‖) is below.
    pub gradient_tolerance: f64,
    /// First radius, in scaled unknowns.
    pub radius: f64,
    /// Largest radius.
    pub max_radius: f64,
}

impl Default for TrustRegion {
    fn default() -> Self {
        Self { max_iterations: 500, gradient_tolerance: 1e-8, radius: 1.0, max_radius: 1e6 }
    }
}

/// argmin's L-BFGS with the line search of Moré and Thuente.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lbfgs {
    /// Largest number of iterations.
    pub max_iterations: usize,
    /// Done when every |J_jᵀ r| / (‖J_j‖ ‖r‖) is below.
    pub gradient_tolerance: f64,
    /// Pairs that are remembered.
    pub memory: usize,
}

impl Default for Lbfgs {
    fn default() -> Self {
        Self { max_iterations: 2000, gradient_tolerance: 1e-8, memory: 10 }
    }
}

impl TrustRegion {
    /// Runs from `start`.
    pub fn minimise(
        &self,
        problem: &dyn NonlinearLeastSquares,
        start: &[f64],
    ) -> Result<NonlinearSolution, SolveError> {
        let bad = |option, value| SolveError::BadOption { option, value, expected: "a finite number > 0" };
        let inner = ArgminTrustRegion::new(Steihaug::new().with_max_iters(2 * start.len().max(1) as u64))
            .with_max_radius(self.max_radius)
            .map_err(|_| bad("max_radius", self.max_radius))?
            .with_radius(self.radius)
            .map_err(|_| bad("radius", self.radius))?;
        let bridge = Bridge::new(problem, start)?;
        let until = Until::new(inner, self.gradient_tolerance);
        let run = Executor::new(&bridge, until)
            .configure(|s: At<Vec<Vec<f64>>>| {
                s.param(bridge.scaled(start)).max_iters(self.max_iterations as u64)
            })
            .run();
        match run {
            Ok(result) => bridge.solution(result.state.best_param, result.solver.status, result.state.iter),
            Err(_) => bridge.solution(None, Some(Status::NumericalFailure), 0),
        }
    }
}

impl Lbfgs {
    /// Runs from `start`.
    pub fn minimise(
        &self,
        problem: &dyn NonlinearLeastSquares,
        start: &[f64],
    ) -> Result<NonlinearSolution, SolveError> {
        let bridge = Bridge::new(problem, start)?;
        let until =
            Until::new(LBFGS::new(MoreThuenteLineSearch::new(), self.memory.max(1)), self.gradient_tolerance);
        let run = Executor::new(&bridge, until)
            .configure(|s: At<()>| s.param(bridge.scaled(start)).max_iters(self.max_iterations as u64))
            .run();
        match run {
            Ok(result) => bridge.solution(result.state.best_param, result.solver.status, result.state.iter),
            Err(_) => bridge.solution(None, Some(Status::NumericalFailure), 0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nonlinear::{FromClosures, LevenbergMarquardt};
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn all_three_reach_the_same_minimum() {
        let t = |i: usize| i as f64 / 20.0;
        let y = move |i: usize| 2.0 * (-0.7 * t(i)).exp() + 0.5 + 0.05 * ((i * i) as f64).sin();
        let problem = FromClosures::new(
            60,
            3,
            move |x: &[f64], r: &mut DVector<f64>| {
                (0..60).for_each(|i| r[i] = x[0] * (-x[1] * t(i)).exp() + x[2] - y(i));
            },
            move |x: &[f64], j: &mut DMatrix<f64>| {
                for i in 0..60 {
                    let e = (-x[1] * t(i)).exp();
                    (j[(i, 0)], j[(i, 1)], j[(i, 2)]) = (e, -t(i) * x[0] * e, 1.0);
                }
            },
        );
        let start = [1.0, 1.0, 0.0];
        let best = LevenbergMarquardt::default().minimise(&problem, &start).unwrap();
        let region = TrustRegion::default().minimise(&problem, &start).unwrap();
        let memory = Lbfgs::default().minimise(&problem, &start).unwrap();
        for other in [&region, &memory] {
            assert!(other.status.is_success(), "{:?} after {}", other.status, other.iterations);
            assert!((&other.x - &best.x).amax() < 1e-5, "{} {}", other.x, best.x);
            assert!((other.residual_norm / best.residual_norm - 1.0).abs() < 1e-10);
        }
        assert!(best.iterations <= region.iterations && best.evaluations < memory.evaluations);
    }
}
