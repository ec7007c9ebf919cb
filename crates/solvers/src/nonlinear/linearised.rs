//! A nonlinear problem at one point, reduced to a triangle, and its damped step.
//!
//! minimise ‖J δ + r‖² + μ ‖D δ‖²:   [R; √μ D] δ = [z; 0] in least squares, with J = Q R, z = −Qᵀ r
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | D | scale of each unknown | p, diagonal | that of J_j |
//! | μ | damping | 1 | 1 |
//! | δ | step | p | that of x |

use super::NonlinearLeastSquares;
use crate::accumulator::{Factor, Triangular};
use crate::dense::{Reflectors, fold, norm, solve_upper};
use faer::MatMut;
use nalgebra::{DMatrix, DVector};

/// The triangle of [J | −r], or nothing if J is not finite.
pub(super) fn reduce<O: NonlinearLeastSquares + ?Sized>(problem: &O, x: &[f64], r: &[f64]) -> Option<Factor> {
    let (m, p) = problem.size();
    let mut j = DMatrix::zeros(m, p);
    problem.jacobian(x, &mut j);
    let right = DMatrix::from_fn(m, 1, |i, _| -r[i]);
    let mut t = Triangular::new(p, 1);
    t.update(&j, &right).ok()?;
    Some(t.finish())
}

/// Largest |J_jᵀ r| / (‖J_j‖ ‖r‖).
pub(super) fn relative_gradient(factor: &Factor, residual: f64) -> f64 {
    if residual < f64::MIN_POSITIVE {
        return 0.0;
    }
    let pulls = factor.r.tr_mul(&factor.z.column(0));
    let norms = factor.column_norms();
    pulls
        .iter()
        .zip(norms)
        .fold(0.0, |top: f64, (g, n)| if n > 0.0 { top.max(g.abs() / n / residual) } else { top })
}

/// A damped step and its reduction predicted by the linear model.
pub(super) struct Step {
    pub delta: DVector<f64>,
    /// Promised reduction of ½ ‖r‖².
    pub promised: f64,
    /// ‖D δ‖.
    pub length: f64,
}

/// δ at damping `mu`. An unknown that has had no influence so far is damped all the same, and stays where it is.
pub(super) fn damped_step(factor: &Factor, scale: &[f64], mu: f64) -> Step {
    let p = factor.columns();
    let mut top = DMatrix::zeros(p, p + 1);
    top.view_mut((0, 0), (p, p)).copy_from(&factor.r);
    top.set_column(p, &factor.z.column(0));
    let weight = |j: usize| if scale[j] > 0.0 { scale[j] } else { 1.0 };
    let mut damping = DMatrix::from_fn(p, p + 1, |i, j| if i == j { mu.sqrt() * weight(j) } else { 0.0 });
    if p > 0 {
        fold(
            MatMut::from_column_major_slice_mut(top.as_mut_slice(), p, p + 1),
            MatMut::from_column_major_slice_mut(damping.as_mut_slice(), p, p + 1),
            &mut Reflectors::default(),
        );
    }
    let right: Vec<f64> = top.column(p).iter().copied().collect();
    let delta = solve_upper(&top, &right);
    let length = norm(&(0..p).map(|j| weight(j) * delta[j]).collect::<Vec<_>>());
    let promised = 0.5 * norm((&factor.r * &delta).as_slice()).powi(2) + mu * length.powi(2);
    Step { delta, promised, length }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nonlinear::FromClosures;

    #[test]
    fn the_step_solves_the_damped_equations() {
        let wave = |i: usize, j: usize| ((i * 7 + j * 5 + i * j) as f64 * 0.37).sin();
        let problem = FromClosures::new(
            12,
            3,
            |_: &[f64], _: &mut DVector<f64>| {},
            move |_: &[f64], j: &mut DMatrix<f64>| {
                (0..12).for_each(|i| (0..3).for_each(|k| j[(i, k)] = wave(i, k)))
            },
        );
        let r = DVector::from_fn(12, |i, _| wave(i, 9));
        let j = DMatrix::from_fn(12, 3, wave);
        let factor = reduce(&problem, &[0.0; 3], r.as_slice()).unwrap();
        let (scale, mu) = ([1.0, 2.0, 0.5], 0.3);
        let step = damped_step(&factor, &scale, mu);
        let squares = DMatrix::from_diagonal(&DVector::from_fn(3, |k, _| mu * scale[k] * scale[k]));
        assert!((j.tr_mul(&(&j * &step.delta + &r)) + squares * &step.delta).amax() < 1e-14);
        let model = |d: &DVector<f64>| 0.5 * (&j * d + &r).norm_squared();
        let promised = model(&DVector::zeros(3)) - model(&step.delta);
        assert!((promised - step.promised).abs() < 1e-13);
        assert!(
            (relative_gradient(&factor, r.norm())
                - (0..3).fold(0.0_f64, |t, k| {
                    t.max(j.column(k).dot(&r).abs() / j.column(k).norm() / r.norm())
                }))
            .abs()
                < 1e-14
        );
    }
}
