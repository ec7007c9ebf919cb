//! Levenberg-Marquardt by QR.
//!
//! minimise ‖J δ + r‖² + μ ‖D δ‖²:   [R; √μ D] δ = [z; 0] in least squares, with J = Q R, z = −Qᵀ r
//!
//! ρ = (½‖r(x)‖² − ½‖r(x+δ)‖²) / (½‖R δ‖² + μ ‖D δ‖²)
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | D | largest norm seen of each column of J | p, diagonal | that of J_j |
//! | μ | damping | 1 | 1 |
//! | ρ | gain: what the step brought over what the model promised | 1 | 1 |
//!
//! Source: Moré (1978) for D and the promised reduction; Nielsen (1999) for the damping: a good step multiplies μ by
//! max(1/3, 1 − (2ρ − 1)³), a bad one by 2, 4, 8 … JᵀJ is never formed, still less inverted, and a deficient J is no
//! obstacle. The Jacobian is reduced once per accepted step; every trial costs p³.

use super::linearised::{Step, damped_step, reduce, relative_gradient};
use super::{NonlinearLeastSquares, NonlinearSolution};
use crate::accumulator::{Factor, Triangular};
use crate::dense::norm;
use crate::problem::check_len;
use crate::{SolveError, Status};
use nalgebra::DVector;

/// Levenberg-Marquardt with damping by the gain ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevenbergMarquardt {
    /// Largest number of accepted steps.
    pub max_iterations: usize,
    /// Done when every |J_jᵀ r| / (‖J_j‖ ‖r‖) is below.
    pub gradient_tolerance: f64,
    /// Done when ‖D δ‖ is below this times ‖D x‖.
    pub step_tolerance: f64,
    /// Done when a step promises less than this times ½ ‖r‖².
    pub reduction_tolerance: f64,
    /// First μ.
    pub damping: f64,
}

impl Default for LevenbergMarquardt {
    fn default() -> Self {
        Self {
            max_iterations: 200,
            gradient_tolerance: 1e-12,
            step_tolerance: 1e-13,
            reduction_tolerance: 1e-16,
            damping: 1e-4,
        }
    }
}

impl LevenbergMarquardt {
    /// Refuses options out of range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let options = [
            ("gradient_tolerance", self.gradient_tolerance),
            ("step_tolerance", self.step_tolerance),
            ("reduction_tolerance", self.reduction_tolerance),
        ];
        for (option, value) in options {
            if !(0.0..1.0).contains(&value) {
                return Err(SolveError::BadOption { option, value, expected: "between 0 and 1" });
            }
        }
        if !(self.damping > 0.0 && self.damping.is_finite()) {
            let value = self.damping;
            return Err(SolveError::BadOption { option: "damping", value, expected: "a finite number > 0" });
        }
        Ok(())
    }

    /// Runs from `start`.
    ///
    /// # Errors
    /// When an option is out of range, or the start has another length or a residual that is not finite.
    pub fn minimise(
        &self,
        problem: &dyn NonlinearLeastSquares,
        start: &[f64],
    ) -> Result<NonlinearSolution, SolveError> {
        self.validate()?;
        let (_, p) = problem.size();
        check_len("the start", p, start.len())?;
        let r = residual(problem, start);
        if let Some(row) = r.iter().position(|v| !v.is_finite()) {
            return Err(SolveError::NotFinite { what: "the residual at the start", row, column: 0 });
        }
        let mut run = Run::new(self, problem, start.to_vec(), r);
        let mut steps = 0;
        while run.status.is_none() && steps < self.max_iterations {
            run.step();
            steps += 1;
        }
        Ok(run.solution())
    }
}

/// A run: where it stands, and what lives between its iterations.
struct Run<'a> {
    options: &'a LevenbergMarquardt,
    problem: &'a dyn NonlinearLeastSquares,
    x: Vec<f64>,
    residual: Vec<f64>,
    mu: f64,
    growth: f64,
    scale: Vec<f64>,
    factor: Option<Factor>,
    gradient: f64,
    iterations: usize,
    evaluations: usize,
    jacobians: usize,
    status: Option<Status>,
}

impl<'a> Run<'a> {
    fn new(
        options: &'a LevenbergMarquardt,
        problem: &'a dyn NonlinearLeastSquares,
        x: Vec<f64>,
        residual: Vec<f64>,
    ) -> Self {
        let mut run = Self {
            options,
            problem,
            x,
            residual,
            mu: options.damping,
            growth: 2.0,
            scale: Vec::new(),
            factor: None,
            gradient: 0.0,
            iterations: 0,
            evaluations: 1,
            jacobians: 0,
            status: None,
        };
        let (x, residual) = (run.x.clone(), run.residual.clone());
        if !run.linearise(&x, &residual) {
            run.status = Some(Status::NumericalFailure);
        } else if run.gradient <= options.gradient_tolerance {
            run.status = Some(Status::Converged);
        }
        run
    }

    /// Reduces the Jacobian at `x`; whether it is finite.
    fn linearise(&mut self, x: &[f64], r: &[f64]) -> bool {
        self.jacobians += 1;
        let Some(factor) = reduce(self.problem, x, r) else { return false };
        let norms = factor.column_norms();
        self.scale.resize(norms.len(), 0.0);
        self.scale.iter_mut().zip(&norms).for_each(|(d, n)| *d = d.max(*n));
        self.gradient = relative_gradient(&factor, norm(r));
        self.factor = Some(factor);
        true
    }

    /// One accepted step, or the end.
    fn step(&mut self) {
        const TRIALS: usize = 60;
        let Some(factor) = self.factor.clone() else {
            self.status = Some(Status::NumericalFailure);
            return;
        };
        let cost = 0.5 * norm(&self.residual).powi(2);
        let size = norm(&self.scale.iter().zip(&self.x).map(|(d, x)| d * x).collect::<Vec<_>>());
        for _ in 0..TRIALS {
            let Step { delta, promised, length } = damped_step(&factor, &self.scale, self.mu);
            let moved: Vec<f64> = self.x.iter().zip(delta.iter()).map(|(x, d)| x + d).collect();
            let after = residual(self.problem, &moved);
            self.evaluations += 1;
            // Difference of squares without their cancellation.
            let brought: f64 =
                0.5 * self.residual.iter().zip(&after).map(|(b, a)| (b - a) * (b + a)).sum::<f64>();
            let gain = brought / promised;
            let small = promised <= self.options.reduction_tolerance * cost
                || length <= self.options.step_tolerance * size;
            if gain > 1e-4 && after.iter().all(|v| v.is_finite()) && self.linearise(&moved, &after) {
                self.mu *= (1.0_f64 / 3.0).max(1.0 - (2.0 * gain - 1.0).powi(3));
                self.mu = self.mu.max(1e-24);
                self.growth = 2.0;
                self.iterations += 1;
                if small || self.gradient <= self.options.gradient_tolerance {
                    self.status = Some(Status::Converged);
                }
                (self.x, self.residual) = (moved, after);
                return;
            }
            if small {
                // The model promises nothing that this arithmetic could deliver.
                self.status = Some(Status::Converged);
                return;
            }
            self.mu *= self.growth;
            self.growth *= 2.0;
        }
        self.status = Some(Status::Stalled);
    }

    fn solution(self) -> NonlinearSolution {
        let columns = self.x.len();
        NonlinearSolution {
            residual_norm: norm(&self.residual),
            x: DVector::from_vec(self.x),
            status: self.status.unwrap_or(Status::MaxIterations),
            gradient: self.gradient,
            iterations: self.iterations,
            evaluations: self.evaluations,
            jacobians: self.jacobians,
            factor: self.factor.unwrap_or_else(|| Triangular::new(columns, 1).finish()),
        }
    }
}

fn residual(problem: &dyn NonlinearLeastSquares, x: &[f64]) -> Vec<f64> {
    let mut r = DVector::zeros(problem.size().0);
    problem.residual(x, &mut r);
    r.as_slice().to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nonlinear::{FromClosures, check_jacobian};
    use nalgebra::DMatrix;

    #[test]
    fn rosenbrock_from_the_usual_start() {
        let problem = FromClosures::new(
            2,
            2,
            |x: &[f64], r: &mut DVector<f64>| {
                r[0] = 10.0 * (x[1] - x[0] * x[0]);
                r[1] = 1.0 - x[0];
            },
            |x: &[f64], j: &mut DMatrix<f64>| j.copy_from_slice(&[-20.0 * x[0], -1.0, 10.0, 0.0]),
        );
        assert!(check_jacobian(&problem, &[-1.2, 1.0], &[1e-3, 1e-3]) < 1e-9);
        let s = LevenbergMarquardt::default().minimise(&problem, &[-1.2, 1.0]).unwrap();
        assert_eq!(s.status, Status::Converged);
        assert!((s.x - DVector::from_element(2, 1.0)).amax() < 1e-12);
        assert!(s.iterations < 30 && s.evaluations >= s.iterations && s.jacobians == s.iterations + 1);
    }

    /// Only x₀ + x₁ matters: JᵀJ cannot be inverted.
    #[test]
    fn a_deficient_jacobian_is_no_obstacle() {
        let t: Vec<f64> = (0..30).map(|i| i as f64 / 10.0).collect();
        let (a, b) = (t.clone(), t.clone());
        let problem = FromClosures::new(
            30,
            3,
            move |x: &[f64], r: &mut DVector<f64>| {
                (0..30).for_each(|i| r[i] = x[2] * (-(x[0] + x[1]) * a[i]).exp() - 2.0 * (-0.7 * a[i]).exp());
            },
            move |x: &[f64], j: &mut DMatrix<f64>| {
                for i in 0..30 {
                    let e = (-(x[0] + x[1]) * b[i]).exp();
                    (j[(i, 0)], j[(i, 1)], j[(i, 2)]) = (-b[i] * x[2] * e, -b[i] * x[2] * e, e);
                }
            },
        );
        let s = LevenbergMarquardt::default().minimise(&problem, &[0.1, 0.1, 1.0]).unwrap();
        assert_eq!(s.status, Status::Converged);
        assert!((s.x[0] + s.x[1] - 0.7).abs() < 1e-9 && (s.x[2] - 2.0).abs() < 1e-9);
        let rank = s.factor.rank(crate::ColumnScale::Norms, crate::RankRule::Default).unwrap();
        assert_eq!(rank.rank, 2);
    }

    /// log of a negative number on the way: the step is shortened.
    #[test]
    fn nan_on_the_way_is_walked_around_and_at_the_start_refused() {
        let problem = FromClosures::new(
            1,
            1,
            |x: &[f64], r: &mut DVector<f64>| r[0] = x[0].ln(),
            |x: &[f64], j: &mut DMatrix<f64>| j[(0, 0)] = 1.0 / x[0],
        );
        let s = LevenbergMarquardt::default().minimise(&problem, &[20.0]).unwrap();
        assert!(s.status == Status::Converged && (s.x[0] - 1.0).abs() < 1e-12, "{s:?}");
        assert!(LevenbergMarquardt::default().minimise(&problem, &[-1.0]).is_err());
        assert!(LevenbergMarquardt::default().minimise(&problem, &[1.0, 2.0]).is_err());
        let short = LevenbergMarquardt { max_iterations: 2, ..Default::default() };
        assert_eq!(short.minimise(&problem, &[20.0]).unwrap().status, Status::MaxIterations);
    }
}
