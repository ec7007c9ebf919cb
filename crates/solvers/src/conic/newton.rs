//! Newton's method with halved steps, on the size of the gradient.
//!
//! u ← u + t d,  d = −H⁻¹ ∇f,  t = 1, ½, ¼, … until ‖∇f‖ falls
//!
//! The Newton direction lowers ‖∇f‖₂ wherever it is smooth. The end games of the cones use it: f is convex, and the start
//! is close.

use nalgebra::DVector;

/// From `start`, while `size` (of the gradient) falls; `direction` gives d, or nothing where there is none.
pub(super) fn newton(
    start: DVector<f64>,
    size: impl Fn(&DVector<f64>) -> f64,
    direction: impl Fn(&DVector<f64>) -> Option<DVector<f64>>,
) -> DVector<f64> {
    const STEPS: usize = 60;
    const HALVINGS: i32 = 30;
    let mut best = (size(&start), start);
    for _ in 0..STEPS {
        let Some(d) = direction(&best.1) else { break };
        let moved = (0..HALVINGS)
            .map(|k| &best.1 + &d * 0.5_f64.powi(k))
            .map(|u| (size(&u), u))
            .find(|m| m.0 < best.0);
        match moved {
            Some(better) => best = better,
            None => break,
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ln cosh: the full step from far away runs off.
    #[test]
    fn halving_saves_a_step_that_is_too_long() {
        let slope = |u: &DVector<f64>| u[0].tanh();
        let end = newton(
            DVector::from_element(1, 3.0),
            |u| slope(u).abs(),
            |u| Some(DVector::from_element(1, -slope(u) * u[0].cosh().powi(2))),
        );
        assert!(end[0].abs() < 1e-12);
    }
}
