//! The damped Gauss–Newton loop of small problems: starts of sensors, placements, projections onto what a file carries.
//!
//! ```text
//! x ← x + δ(μ)  where the cost falls, then μ ← good · μ;  else μ ← bad · μ
//! ```
//!
//! δ(μ) is the caller's: it knows its unknowns (which may be rotations) and its normal equations. Fits of measured data have noise to
//! estimate between the steps and a trust region in expected sizes (`identify`), and `solvers` has Levenberg and Marquardt's method for
//! problems of residual and Jacobian; both are other loops.
//!
//! Source: Levenberg 1944, Marquardt 1963.

/// How damping μ changes, and when a descent ends.
#[derive(Debug, Clone, Copy)]
pub struct Schedule {
    /// The first μ.
    pub first: f64,
    /// Factor of μ after a step that lowered the cost, below one, and the least μ.
    pub good: (f64, f64),
    /// Factor of μ after a step that did not, above one, and the largest μ: beyond it the descent ends.
    pub bad: (f64, f64),
    /// Steps at most.
    pub steps: usize,
    /// Steps in a row that gained at most `flat`, and failed steps in a row, after which the descent ends.
    pub patience: (usize, usize),
    /// A gain that counts as none, in the unit of [`Schedule::gain`].
    pub flat: f64,
    /// The gain of a step from its costs, before and after: a difference, or a relative one.
    pub gain: fn(f64, f64) -> f64,
}

/// `(before − after) / before`.
pub fn relative_gain(before: f64, after: f64) -> f64 {
    (before - after) / before.max(f64::MIN_POSITIVE)
}

/// `before − after`.
pub fn difference(before: f64, after: f64) -> f64 {
    before - after
}

/// Descends from `start`, whose cost is `cost`, and gives where it ended with its cost.
///
/// `propose` makes a step at a damping: where it leads, with the cost there (not finite: it leads nowhere); `None` ends the descent.
/// `accept` completes where a step led to, for the next one (its derivatives, say).
pub fn descend<S, T>(
    (start, cost): (S, f64),
    schedule: &Schedule,
    mut propose: impl FnMut(&S, f64) -> Option<(T, f64)>,
    mut accept: impl FnMut(T) -> S,
) -> (S, f64) {
    let (mut at, mut cost) = (start, cost);
    let mut damping = schedule.first;
    let (mut flat, mut failed) = (0, 0);
    for _ in 0..schedule.steps {
        let Some((next, then)) = propose(&at, damping) else { break };
        if then < cost {
            let gain = (schedule.gain)(cost, then);
            (at, cost) = (accept(next), then);
            damping = (damping * schedule.good.0).max(schedule.good.1);
            flat = if gain > schedule.flat { 0 } else { flat + 1 };
            failed = 0;
        } else {
            damping *= schedule.bad.0;
            failed += 1;
        }
        if flat >= schedule.patience.0 || failed >= schedule.patience.1 || damping > schedule.bad.1 {
            break;
        }
    }
    (at, cost)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCHEDULE: Schedule = Schedule {
        first: 1e-3,
        good: (0.1, 1e-14),
        bad: (10.0, 1e12),
        steps: 200,
        patience: (1, usize::MAX),
        flat: 1e-13,
        gain: relative_gain,
    };

    /// Residuals 10 (y − x²) and 1 − x of Rosenbrock's valley, and a damped step.
    fn residuals([x, y]: [f64; 2]) -> [f64; 2] {
        [10.0 * (y - x * x), 1.0 - x]
    }

    fn cost(at: [f64; 2]) -> f64 {
        residuals(at).iter().map(|r| r * r).sum()
    }

    fn step(&[x, y]: &[f64; 2], damping: f64) -> Option<([f64; 2], f64)> {
        let ([r, s], j) = (residuals([x, y]), nalgebra::Matrix2::new(-20.0 * x, 10.0, -1.0, 0.0));
        let normal = j.transpose() * j + nalgebra::Matrix2::identity() * damping;
        let moved = normal.cholesky()?.solve(&(-j.transpose() * nalgebra::Vector2::new(r, s)));
        let next = [x + moved.x, y + moved.y];
        Some((next, cost(next)))
    }

    #[test]
    fn it_follows_a_bent_valley_to_its_end() {
        let start = [-1.2, 1.0];
        let (end, left) = descend((start, cost(start)), &SCHEDULE, step, |next| next);
        assert!(left < 1e-20 && (end[0] - 1.0).abs() < 1e-9, "{end:?} {left}");
    }

    #[test]
    fn it_never_ends_above_its_start_and_ends_where_nothing_helps() {
        let mut proposals = 0;
        let worse = |at: &f64, _: f64| {
            proposals += 1;
            Some((*at, f64::NAN))
        };
        let (end, left) = descend((2.0, 4.0), &SCHEDULE, worse, |next| next);
        assert!((end - 2.0).abs() < 1e-15 && (left - 4.0).abs() < 1e-15);
        // From 1e-3 to beyond 1e12 by tens.
        assert_eq!(proposals, 16);
        let impatient = Schedule { patience: (1, 3), ..SCHEDULE };
        let mut proposals = 0;
        descend(
            (2.0, 4.0),
            &impatient,
            |at: &f64, _| {
                proposals += 1;
                Some((*at, 5.0))
            },
            |next| next,
        );
        assert_eq!(proposals, 3);
    }
}
