//! How far a step may go: a region of trust around the point of linearisation, measured in expected sizes.
//!
//! ```text
//! u = W₁ (β − β_now)     min ‖R L u − z‖² + ‖W (β_now + L u)‖²,  ‖u‖ ≤ Δ     ⇔     (M + λ 1) u = g,  λ ≥ 0, λ (‖u‖ − Δ) = 0
//! ```
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | L = W₁⁻¹ | spread of the prior for κ = 1 | r × r | as β |
//! | M = LᵀRᵀR L + 1/κ² | curvature of the objective | r × r | 1 |
//! | g = LᵀRᵀz − W₁ β_now/κ² | half its slope, downhill | r | 1 |
//! | Δ | radius | 1 | expected sizes |
//!
//! λ by Hebden's iteration on `1/‖u‖`, which is nearly a straight line in λ. Source: Moré (1978); Nocedal and Wright (2006), ch. 4.

use super::state::State;
use crate::reduction::Reduction;
use nalgebra::{DMatrix, DVector};
use truepose_solvers::accumulator::Factor;

/// The region, and the damping that keeps a step in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Trust {
    /// Δ.
    pub radius: f64,
    /// λ of the next step.
    pub damping: f64,
}

/// What a step is expected to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Promise {
    /// By how much the objective falls in the linear picture.
    pub gain: f64,
    /// ‖u‖.
    pub length: f64,
    /// Length in standard deviations of what is being found, `√(δᵀ(RᵀR + WᵀW)δ)`: no unknown moves by more of its own.
    pub deviations: f64,
}

impl Default for Trust {
    fn default() -> Self {
        Trust { radius: f64::INFINITY, damping: 0.0 }
    }
}

impl Trust {
    /// The radius after a step of this length that kept this share of its promise.
    pub(super) fn after(&mut self, length: f64, kept: f64) {
        if kept < 0.25 {
            // Where a parabola through the objective, its slope and the step's end is lowest: t = 1/(2 (2 − kept)) of the step.
            let share = if kept.is_finite() { 0.5 / (2.0 - kept).max(0.5) } else { 0.1 };
            self.radius = length * share.clamp(0.1, 0.5);
        } else if kept > 0.75 {
            self.radius = self.radius.max(2.5 * length);
        }
    }
}

impl State<'_> {
    /// What a step from here to these coefficients promises.
    pub(super) fn promise(&self, reduction: &Reduction, factor: &Factor, target: &[f64]) -> Promise {
        let now = DVector::from_vec(reduction.grouped(&self.coefficients));
        let change = DVector::from_vec(reduction.grouped(target)) - &now;
        let moved = &factor.r * &change;
        let z = factor.z.column(0);
        let (mut gain, mut squares) = (2.0 * z.dot(&moved) - moved.norm_squared(), moved.norm_squared());
        let unit = self.prior.unit_rows();
        let step = unit * &change;
        if self.prior.kappa.is_finite() {
            let weight = 1.0 / (self.prior.kappa * self.prior.kappa);
            let held = unit * &now;
            gain -= weight * (2.0 * held.dot(&step) + step.norm_squared());
            squares += weight * step.norm_squared();
        }
        Promise { gain, length: step.norm(), deviations: squares.sqrt() }
    }

    /// The λ that keeps the step from here within the region; zero where it ends within by itself.
    pub(super) fn damping(&self, reduction: &Reduction, factor: &Factor, radius: f64) -> f64 {
        /// Relative precision of the length: a region of trust is no sharper.
        const NEAR: f64 = 0.1;
        const MOST: usize = 30;
        if !radius.is_finite() {
            return 0.0;
        }
        let spread = self.prior.spread();
        let data = &factor.r * spread;
        let mut curvature = data.tr_mul(&data);
        let mut slope = data.tr_mul(&factor.z.column(0));
        if self.prior.kappa.is_finite() {
            let weight = 1.0 / (self.prior.kappa * self.prior.kappa);
            let now = DVector::from_vec(reduction.grouped(&self.coefficients));
            slope -= self.prior.unit_rows() * now * weight;
            (0..curvature.nrows()).for_each(|k| curvature[(k, k)] += weight);
        }
        let largest = slope.norm();
        // From above, ‖u‖ ≤ ‖g‖/λ: there the iteration stays on its side.
        let mut damping = 0.0_f64;
        let floor = f64::EPSILON * curvature.trace().max(f64::MIN_POSITIVE);
        for _ in 0..MOST {
            let Some((length, fall)) = length(&curvature, damping.max(floor), &slope) else {
                damping = (10.0 * damping).max(1e3 * floor);
                continue;
            };
            if length <= radius * (1.0 + NEAR) && (damping <= 0.0 || length >= radius * (1.0 - NEAR)) {
                return damping;
            }
            let next = damping + (length / radius - 1.0) * length * length / fall;
            damping = next.clamp(0.0, largest / radius);
        }
        damping
    }
}

/// ‖u‖ at λ, and uᵀ (M + λ)⁻¹ u; none where M + λ is not definite in this arithmetic.
fn length(curvature: &DMatrix<f64>, damping: f64, slope: &DVector<f64>) -> Option<(f64, f64)> {
    let mut shifted = curvature.clone();
    (0..shifted.nrows()).for_each(|k| shifted[(k, k)] += damping);
    let root = shifted.cholesky()?;
    let step = root.solve(slope);
    let behind = root.l_dirty().solve_lower_triangular(&step)?;
    Some((step.norm(), behind.norm_squared()))
}
