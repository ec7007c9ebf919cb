//! Variable projection: the unknowns in which the problem is linear are solved for at every trial of the others.
//!
//! r(θ) = A(θ) c(θ) − y,  c(θ) = A(θ)⁺ y,  ∂r/∂θ_k ≈ (I − A A⁺) (∂A/∂θ_k) c
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | θ | shape parameters: a period, a time constant, an exponent | q | each its own |
//! | A(θ) | whitened design matrix | m × p | – |
//! | c | coefficients | p | each its own |
//! | y | whitened observations | m | 1 |
//!
//! Source: Golub and Pereyra (1973), with Kaufman's (1975) Jacobian: its gradient is exact, and it needs only the derivative
//! of A applied to c.

use super::{LevenbergMarquardt, NonlinearLeastSquares, NonlinearSolution};
use crate::accumulator::{ColumnScale, Triangular};
use crate::{LeastSquares, PivotedQr, RankRule, Solution, SolveError, Solver};
use nalgebra::{DMatrix, DVector};

/// A problem that is linear in most of its unknowns.
pub trait Separable {
    /// Rows m, coefficients p, shape parameters q.
    fn size(&self) -> (usize, usize, usize);
    /// Writes A(θ), m × p, whitened.
    fn basis(&self, shape: &[f64], out: &mut DMatrix<f64>);
    /// y, whitened.
    fn observed(&self) -> &DVector<f64>;
    /// Writes (∂A/∂θ_k) c, m entries. By central differences unless given.
    fn derivative(&self, shape: &[f64], k: usize, c: &DVector<f64>, out: &mut DVector<f64>) {
        let (m, p, _) = self.size();
        let step = f64::EPSILON.cbrt() * shape[k].abs().max(1e-3);
        let mut moved = shape.to_vec();
        let (mut above, mut below) = (DMatrix::zeros(m, p), DMatrix::zeros(m, p));
        moved[k] = shape[k] + step;
        self.basis(&moved, &mut above);
        let up = moved[k];
        moved[k] = shape[k] - step;
        self.basis(&moved, &mut below);
        out.copy_from(&((above * c - below * c) / (up - moved[k])));
    }
}

/// A separable problem as one in its shape parameters alone.
#[derive(Clone, Copy)]
pub struct Profiled<'a> {
    problem: &'a dyn Separable,
    /// Where the rank of A(θ) ends.
    pub rank: RankRule,
}

/// Shape parameters and coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfiledSolution {
    /// The search over θ.
    pub shape: NonlinearSolution,
    /// The coefficients at the end of it.
    pub coefficients: Solution,
}

impl<'a> Profiled<'a> {
    /// With the default rule for the rank.
    pub fn new(problem: &'a dyn Separable) -> Self {
        Self { problem, rank: RankRule::Default }
    }

    fn basis(&self, shape: &[f64]) -> DMatrix<f64> {
        let (m, p, _) = self.problem.size();
        let mut a = DMatrix::zeros(m, p);
        self.problem.basis(shape, &mut a);
        a
    }

    /// The coefficients at θ.
    pub fn coefficients(&self, shape: &[f64]) -> Result<Solution, SolveError> {
        let a = self.basis(shape);
        PivotedQr { rank: self.rank }.solve(&LeastSquares::new(&a, self.problem.observed()))
    }

    /// The part of each column of `b` that no column of `a` reaches.
    fn beyond(&self, a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<DMatrix<f64>, SolveError> {
        let mut t = Triangular::new(a.ncols(), b.ncols());
        t.update(a, b)?;
        let factor = t.finish();
        let mut left = b.clone();
        for k in 0..b.ncols() {
            let c = factor.solve_pivoted(k, ColumnScale::Norms, self.rank)?;
            let column = b.column(k) - a * c.x;
            left.set_column(k, &column);
        }
        Ok(left)
    }

    fn try_jacobian(&self, shape: &[f64]) -> Result<DMatrix<f64>, SolveError> {
        let (m, _, q) = self.problem.size();
        let a = self.basis(shape);
        let c = self.coefficients(shape)?.x;
        let mut slopes = DMatrix::zeros(m, q);
        let mut column = DVector::zeros(m);
        for k in 0..q {
            self.problem.derivative(shape, k, &c, &mut column);
            slopes.set_column(k, &column);
        }
        self.beyond(&a, &slopes)
    }
}

impl NonlinearLeastSquares for Profiled<'_> {
    fn size(&self) -> (usize, usize) {
        let (m, _, q) = self.problem.size();
        (m, q)
    }

    fn residual(&self, shape: &[f64], out: &mut DVector<f64>) {
        match self.coefficients(shape) {
            Ok(s) => out.copy_from(&(self.basis(shape) * s.x - self.problem.observed())),
            Err(_) => out.fill(f64::NAN),
        }
    }

    fn jacobian(&self, shape: &[f64], out: &mut DMatrix<f64>) {
        match self.try_jacobian(shape) {
            Ok(j) => out.copy_from(&j),
            Err(_) => out.fill(f64::NAN),
        }
    }
}

/// Fits shape parameters from `start`, coefficients being solved for throughout.
pub fn profile(
    problem: &dyn Separable,
    start: &[f64],
    search: &LevenbergMarquardt,
) -> Result<ProfiledSolution, SolveError> {
    let profiled = Profiled::new(problem);
    let shape = search.minimise(&profiled, start)?;
    let coefficients = profiled.coefficients(shape.x.as_slice())?;
    Ok(ProfiledSolution { shape, coefficients })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Status;
    use crate::nonlinear::{FromClosures, check_jacobian};

    /// c₀ + c₁ sin(2πt/θ₀) + c₂ cos(2πt/θ₀) + c₃ exp(−t/θ₁)
    struct Wave {
        t: Vec<f64>,
        y: DVector<f64>,
    }

    fn row(t: f64, shape: &[f64]) -> [f64; 4] {
        let (s, c) = (std::f64::consts::TAU * t / shape[0]).sin_cos();
        [1.0, s, c, (-t / shape[1]).exp()]
    }

    impl Wave {
        fn new() -> Self {
            let t: Vec<f64> = (0..120).map(|i| i as f64 / 12.0).collect();
            let y = DVector::from_fn(120, |i, _| {
                let r = row(t[i], &[2.9, 4.0]);
                0.3 + 1.5 * r[1] - 0.4 * r[2] + 2.0 * r[3] + 0.02 * ((i * i) as f64 * 0.7).sin()
            });
            Self { t, y }
        }
    }

    impl Separable for Wave {
        fn size(&self) -> (usize, usize, usize) {
            (120, 4, 2)
        }
        fn basis(&self, shape: &[f64], out: &mut DMatrix<f64>) {
            (0..120).for_each(|i| (0..4).for_each(|j| out[(i, j)] = row(self.t[i], shape)[j]));
        }
        fn observed(&self) -> &DVector<f64> {
            &self.y
        }
    }

    #[test]
    fn profiled_and_joint_agree() {
        let wave = Wave::new();
        let profiled = profile(&wave, &[3.1, 2.0], &LevenbergMarquardt::default()).unwrap();
        assert!(profiled.shape.status.is_success());
        assert!((profiled.shape.x[0] - 2.9).abs() < 0.01 && (profiled.shape.x[1] - 4.0).abs() < 0.1);

        let joint = FromClosures::new(
            120,
            6,
            |x: &[f64], r: &mut DVector<f64>| {
                (0..120).for_each(|i| {
                    let a = row(wave.t[i], &x[4..]);
                    r[i] = (0..4).map(|j| a[j] * x[j]).sum::<f64>() - wave.y[i];
                });
            },
            |x: &[f64], out: &mut DMatrix<f64>| {
                for (i, &t) in wave.t.iter().enumerate() {
                    let a = row(t, &x[4..]);
                    (0..4).for_each(|j| out[(i, j)] = a[j]);
                    let turn = -std::f64::consts::TAU * t / x[4].powi(2);
                    out[(i, 4)] = turn * (x[1] * a[2] - x[2] * a[1]);
                    out[(i, 5)] = x[3] * a[3] * t / x[5].powi(2);
                }
            },
        );
        let at = [0.0, 1.0, 0.0, 1.0, 3.1, 2.0];
        assert!(check_jacobian(&joint, &at, &[1e-2; 6]) < 1e-6);
        let both = LevenbergMarquardt::default().minimise(&joint, &at).unwrap();
        assert_eq!(both.status, Status::Converged);
        for k in 0..2 {
            assert!((both.x[4 + k] / profiled.shape.x[k] - 1.0).abs() < 1e-7);
        }
        for j in 0..4 {
            assert!((both.x[j] - profiled.coefficients.x[j]).abs() < 1e-6);
        }
        assert!((both.residual_norm / profiled.shape.residual_norm - 1.0).abs() < 1e-10);
    }

    #[test]
    fn the_gradient_of_the_profile_is_exact() {
        let wave = Wave::new();
        let p = Profiled::new(&wave);
        let at = [3.0, 3.0];
        let (mut r, mut j) = (DVector::zeros(120), DMatrix::zeros(120, 2));
        p.residual(&at, &mut r);
        p.jacobian(&at, &mut j);
        let gradient = j.tr_mul(&r);
        for k in 0..2 {
            let cost = |step: f64| {
                let mut moved = at;
                moved[k] += step;
                let mut r = DVector::zeros(120);
                p.residual(&moved, &mut r);
                0.5 * r.norm_squared()
            };
            let slope = (cost(1e-5) - cost(-1e-5)) / 2e-5;
            assert!((slope - gradient[k]).abs() < 1e-6 * slope.abs().max(1.0), "{slope} {}", gradient[k]);
        }
    }
}
