//! argmin's trust region and L-BFGS on the same problem, for comparison.
//!
//! f(u) = ½ ‖r(S u)‖²,  ∇f = S Jᵀ r,  H ≈ S Jᵀ J S
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | S | one over the norm of each column of J at the start | p × p, diagonal |
//!
//! Both form what Levenberg-Marquardt avoids: JᵀJ, or nothing but the gradient. Neither of argmin's two ends on the relative
//! gradient of a least-squares problem, so a wrapper does that.

use super::levenberg_marquardt::{reduce, relative_gradient};
use super::{NonlinearLeastSquares, NonlinearSolution};
use crate::accumulator::Triangular;
use crate::dense::norm;
use crate::problem::check_len;
use crate::{SolveError, Status};
use argmin::core::{
    CostFunction, Error, Executor, Gradient, Hessian, IterState, KV, Problem, Solver, State,
    TerminationReason, TerminationStatus,
};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use argmin::solver::trustregion::{Steihaug, TrustRegion as ArgminTrustRegion};
use nalgebra::{DMatrix, DVector};

/// Where argmin's solvers are: unknowns and gradient are vectors, H is the Hessian.
type At<H> = IterState<Vec<f64>, Vec<f64>, (), H, (), f64>;

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

/// The problem in argmin's words, in scaled unknowns.
struct Bridge<'a> {
    problem: &'a dyn NonlinearLeastSquares,
    scale: Vec<f64>,
    counts: std::cell::Cell<(usize, usize)>,
}

impl<'a> Bridge<'a> {
    fn new(problem: &'a dyn NonlinearLeastSquares, start: &[f64]) -> Result<Self, SolveError> {
        let (m, p) = problem.size();
        check_len("the start", p, start.len())?;
        let mut r = DVector::zeros(m);
        problem.residual(start, &mut r);
        if let Some(row) = r.iter().position(|v| !v.is_finite()) {
            return Err(SolveError::NotFinite { what: "the residual at the start", row, column: 0 });
        }
        let Some(factor) = reduce(problem, start, r.as_slice()) else {
            return Err(SolveError::NotFinite { what: "the Jacobian at the start", row: 0, column: 0 });
        };
        let scale = factor
            .column_norms()
            .iter()
            .map(|n| if *n >= f64::MIN_POSITIVE { 1.0 / n } else { 1.0 })
            .collect();
        Ok(Self { problem, scale, counts: std::cell::Cell::new((1, 1)) })
    }

    fn scaled(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.scale).map(|(x, s)| x / s).collect()
    }

    fn x(&self, u: &[f64]) -> Vec<f64> {
        u.iter().zip(&self.scale).map(|(u, s)| u * s).collect()
    }

    fn residual(&self, u: &[f64]) -> DVector<f64> {
        let (r, j) = self.counts.get();
        self.counts.set((r + 1, j));
        let mut out = DVector::zeros(self.problem.size().0);
        self.problem.residual(&self.x(u), &mut out);
        out
    }

    /// J S.
    fn jacobian(&self, u: &[f64]) -> DMatrix<f64> {
        let (r, j) = self.counts.get();
        self.counts.set((r, j + 1));
        let (m, p) = self.problem.size();
        let mut out = DMatrix::zeros(m, p);
        self.problem.jacobian(&self.x(u), &mut out);
        out.column_iter_mut().zip(&self.scale).for_each(|(mut c, s)| c *= *s);
        out
    }

    fn solution(
        &self,
        best: Option<Vec<f64>>,
        status: Option<Status>,
        iterations: u64,
    ) -> Result<NonlinearSolution, SolveError> {
        let (m, p) = self.problem.size();
        let (evaluations, jacobians) = self.counts.get();
        let Some(u) = best else {
            return Ok(NonlinearSolution {
                x: DVector::from_element(p, f64::NAN),
                status: status.unwrap_or(Status::NumericalFailure),
                residual_norm: f64::NAN,
                gradient: f64::NAN,
                iterations: 0,
                evaluations,
                jacobians,
                factor: Triangular::new(p, 1).finish(),
            });
        };
        let x = self.x(&u);
        let mut r = DVector::zeros(m);
        self.problem.residual(&x, &mut r);
        let residual_norm = norm(r.as_slice());
        let factor = reduce(self.problem, &x, r.as_slice());
        Ok(NonlinearSolution {
            x: DVector::from_vec(x),
            status: status.unwrap_or(Status::MaxIterations),
            residual_norm,
            gradient: factor.as_ref().map_or(f64::NAN, |f| relative_gradient(f, residual_norm)),
            iterations: iterations as usize,
            evaluations,
            jacobians,
            factor: factor.unwrap_or_else(|| Triangular::new(p, 1).finish()),
        })
    }
}

impl CostFunction for &Bridge<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, u: &Vec<f64>) -> Result<f64, Error> {
        let size = norm(self.residual(u).as_slice());
        Ok(if size.is_finite() { 0.5 * size * size } else { f64::INFINITY })
    }
}

impl Gradient for &Bridge<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, u: &Vec<f64>) -> Result<Vec<f64>, Error> {
        Ok(self.jacobian(u).tr_mul(&self.residual(u)).as_slice().to_vec())
    }
}

impl Hessian for &Bridge<'_> {
    type Param = Vec<f64>;
    type Hessian = Vec<Vec<f64>>;

    fn hessian(&self, u: &Vec<f64>) -> Result<Vec<Vec<f64>>, Error> {
        let j = self.jacobian(u);
        let h = j.tr_mul(&j);
        Ok(h.row_iter().map(|row| row.iter().copied().collect()).collect())
    }
}

/// Another solver, ended when the scaled gradient is small against the residual, or when the cost has stood still.
struct Until<S> {
    inner: S,
    tolerance: f64,
    standing: usize,
    status: Option<Status>,
}

impl<S> Until<S> {
    fn new(inner: S, tolerance: f64) -> Self {
        Self { inner, tolerance, standing: 0, status: None }
    }
}

impl<O, S, H> Solver<O, At<H>> for Until<S>
where
    S: Solver<O, At<H>>,
    At<H>: State<Float = f64>,
{
    fn name(&self) -> &str {
        self.inner.name()
    }

    fn init(&mut self, problem: &mut Problem<O>, state: At<H>) -> Result<(At<H>, Option<KV>), Error> {
        self.inner.init(problem, state)
    }

    fn next_iter(&mut self, problem: &mut Problem<O>, state: At<H>) -> Result<(At<H>, Option<KV>), Error> {
        self.inner.next_iter(problem, state)
    }

    fn terminate(&mut self, state: &At<H>) -> TerminationStatus {
        const PATIENCE: usize = 20;
        let size = (2.0 * state.cost).sqrt();
        let pull =
            state.grad.as_ref().map_or(f64::INFINITY, |g| g.iter().fold(0.0, |t: f64, g| t.max(g.abs())));
        if pull <= self.tolerance * size || size < f64::MIN_POSITIVE {
            self.status = Some(Status::Converged);
            return TerminationStatus::Terminated(TerminationReason::SolverConverged);
        }
        let still = (state.prev_cost - state.cost).abs() <= f64::EPSILON * state.cost;
        self.standing = if still { self.standing + 1 } else { 0 };
        if self.standing >= PATIENCE {
            self.status = Some(Status::Stalled);
            return TerminationStatus::Terminated(TerminationReason::SolverExit("stalled".to_owned()));
        }
        TerminationStatus::NotTerminated
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nonlinear::{FromClosures, LevenbergMarquardt};

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
