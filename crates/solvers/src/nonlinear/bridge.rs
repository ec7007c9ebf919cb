//! A nonlinear problem in argmin's words, and an end for argmin's solvers.
//!
//! f(u) = ½ ‖r(S u)‖²,  ∇f = S Jᵀ r,  H ≈ S Jᵀ J S
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | S | one over the norm of each column of J at the start | p × p, diagonal |

use super::linearised::{reduce, relative_gradient};
use super::{NonlinearLeastSquares, NonlinearSolution};
use crate::accumulator::Triangular;
use crate::dense::norm;
use crate::problem::check_len;
use crate::{SolveError, Status};
use argmin::core::{
    CostFunction, Error, Gradient, Hessian, IterState, KV, Problem, Solver, State, TerminationReason,
    TerminationStatus,
};
use nalgebra::{DMatrix, DVector};

/// Where argmin's solvers are: unknowns and gradient are vectors, H is the Hessian.
pub(super) type At<H> = IterState<Vec<f64>, Vec<f64>, (), H, (), f64>;

/// The problem in argmin's words, in scaled unknowns.
pub(super) struct Bridge<'a> {
    problem: &'a dyn NonlinearLeastSquares,
    scale: Vec<f64>,
    counts: std::cell::Cell<(usize, usize)>,
}

impl<'a> Bridge<'a> {
    pub fn new(problem: &'a dyn NonlinearLeastSquares, start: &[f64]) -> Result<Self, SolveError> {
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

    pub fn scaled(&self, x: &[f64]) -> Vec<f64> {
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

    pub fn solution(
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
pub(super) struct Until<S> {
    inner: S,
    tolerance: f64,
    standing: usize,
    pub status: Option<Status>,
}

impl<S> Until<S> {
    pub fn new(inner: S, tolerance: f64) -> Self {
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
