//! Least squares within bounds.
//!
//! minimise ½ ‖M u − z‖²  over  l ≤ u ≤ b
//!
//! optimal: g = Mᵀ (M u − z) is 0 inside, ≥ 0 at l, ≤ 0 at b
//!
//! The inner solver is run first: if its answer lies within the bounds it is the answer. If not, an interior point
//! finds which bounds bind, and an active-set iteration by QR makes the answer exact.

use super::box_descent::descend;
use super::core::{Core, Inner};
use super::program::Program;
use super::shifted::shifted;
use crate::accumulator::Factor;
use crate::{LeastSquares, Need, PivotedQr, Solution, SolveError, Solver};
use nalgebra::DVector;

/// A solver made to respect bounds.
#[derive(Debug, Clone)]
pub struct Bounded<S = PivotedQr> {
    name: String,
    inner: S,
}

impl<S: Solver> Bounded<S> {
    /// `inner` within bounds; it has to be free of penalties, because the bounded fit is.
    pub fn new(inner: S) -> Self {
        Self { name: format!("bounded({})", inner.name()), inner }
    }
}

impl Default for Bounded {
    fn default() -> Self {
        Self::new(PivotedQr::default())
    }
}

impl<S: Solver> Solver for Bounded<S> {
    fn name(&self) -> &str {
        &self.name
    }

    fn supports(&self, need: Need) -> bool {
        match need {
            Need::Bounds => true,
            Need::Outliers | Need::ColumnGroups => false,
            other => self.inner.supports(other),
        }
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        problem.admit(self)?;
        if !self.inner.supports(Need::Unpenalised) || self.inner.supports(Need::Outliers) {
            return Err(SolveError::Unsupported { solver: self.name.clone(), need: Need::Unpenalised });
        }
        let free = self.inner.solve(&LeastSquares { bounds: None, ..*problem })?;
        let Some(bounds) = problem.bounds.filter(|b| b.any()) else { return Ok(free) };
        if free.status.is_success() && bounds.contains(free.x.as_slice()) {
            return Ok(free);
        }
        let core = Core::new(&Factor::of_valid(problem))?;
        let scaled =
            |values: &[f64]| DVector::from_fn(core.live.len(), |k, _| values[core.live[k]] / core.unit[k]);
        let (lower, upper) = (scaled(&bounds.lower), scaled(&bounds.upper));
        let inner = solve(&core, &lower, &upper);
        let mut solution = core.solution(problem, &inner);
        if inner.u.is_some() {
            for j in 0..problem.columns() {
                solution.x[j] = solution.x[j].clamp(bounds.lower[j], bounds.upper[j]);
            }
            // A variable at its scaled bound is at its bound, not a rounding away from it.
            if let Some(u) = &inner.u {
                for (k, &j) in core.live.iter().enumerate() {
                    if u[k] <= lower[k] {
                        solution.x[j] = bounds.lower[j];
                    } else if u[k] >= upper[k] {
                        solution.x[j] = bounds.upper[j];
                    }
                }
            }
        }
        Ok(problem.with_true_residual(solution))
    }
}

/// What the exchange of active sets reaches where it does not go in circles.
const EXACT: f64 = 1e-12;

fn solve(core: &Core, lower: &DVector<f64>, upper: &DVector<f64>) -> Inner {
    let p = core.live.len();
    let mut program = Program::residual_form(&core.m, &core.z);
    let mut count = 0;
    for k in 0..p {
        if upper[k].is_finite() {
            program.row(&[(k, 1.0)], upper[k]);
            count += 1;
        }
        if lower[k].is_finite() {
            program.row(&[(k, -1.0)], -lower[k]);
            count += 1;
        }
    }
    if count > 0 {
        program.inequalities(count);
    }
    let ended = program.run();
    if ended.v.is_empty() && p > 0 {
        return Inner::failed(ended.status, ended.iterations);
    }
    let interior = DVector::from_fn(p, |k, _| ended.v[k].clamp(lower[k], upper[k]));
    let judged = |u: DVector<f64>| {
        let v = violation(core, lower, upper, &u);
        (u, v)
    };
    let exchanged = active_set(core, lower, upper, &interior).map(judged).filter(|e| e.1 <= EXACT);
    let polished = exchanged.or_else(|| descend(core, lower, upper, &interior).map(judged));
    let v = violation(core, lower, upper, &interior);
    Inner::best((interior, v), polished, ended.status, ended.iterations)
}

/// Largest violation of the optimality conditions.
fn violation(core: &Core, lower: &DVector<f64>, upper: &DVector<f64>, u: &DVector<f64>) -> f64 {
    let g = core.gradient(u);
    (0..u.len()).fold(0.0, |worst: f64, k| {
        let down = if u[k] > lower[k] { g[k] } else { 0.0 };
        let up = if u[k] < upper[k] { -g[k] } else { 0.0 };
        worst.max(down).max(up)
    })
}

/// Solves for the variables that no bound holds, and moves the set until nothing wants to move.
fn active_set(
    core: &Core,
    lower: &DVector<f64>,
    upper: &DVector<f64>,
    start: &DVector<f64>,
) -> Option<DVector<f64>> {
    #[derive(Clone, Copy, PartialEq)]
    enum At {
        Free,
        Lower,
        Upper,
    }
    const SETTLED: f64 = 1e-14;
    let p = start.len();
    let g = core.gradient(start);
    let near = |a: f64, b: f64, pull: f64| {
        pull > 0.0 && (a - b).abs() < 1e-3 * pull.sqrt().min(1.0) * (1.0 + b.abs())
    };
    let mut at: Vec<At> = (0..p)
        .map(|k| match () {
            () if near(start[k], lower[k], g[k]) => At::Lower,
            () if near(start[k], upper[k], -g[k]) => At::Upper,
            () => At::Free,
        })
        .collect();
    for _ in 0..3 * p + 10 {
        let free: Vec<usize> = (0..p).filter(|k| at[*k] == At::Free).collect();
        let held = DVector::from_fn(p, |k, _| match at[k] {
            At::Free => 0.0,
            At::Lower => lower[k],
            At::Upper => upper[k],
        });
        let part = core.m.select_columns(&free);
        let solved = shifted(&part, &(&core.z - &core.m * &held), &DVector::zeros(free.len()))?;
        let mut u = held;
        free.iter().zip(solved.iter()).for_each(|(k, v)| u[*k] = *v);

        // The variable that leaves its bounds furthest is held there.
        let over = |k: usize| (lower[k] - u[k]).max(u[k] - upper[k]);
        if let Some(k) =
            free.iter().copied().filter(|k| over(*k) > 0.0).max_by(|a, b| over(*a).total_cmp(&over(*b)))
        {
            at[k] = if u[k] < lower[k] { At::Lower } else { At::Upper };
            continue;
        }
        // The bound that pulls the wrong way hardest lets go.
        let g = core.gradient(&u);
        let wrong = |k: usize| match at[k] {
            At::Free => 0.0,
            At::Lower if lower[k] < upper[k] => -g[k],
            At::Upper if lower[k] < upper[k] => g[k],
            _ => 0.0,
        };
        match (0..p).filter(|k| wrong(*k) > SETTLED).max_by(|a, b| wrong(*a).total_cmp(&wrong(*b))) {
            Some(k) => at[k] = At::Free,
            None => return Some(u),
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bounds, NormalEquations, Status, Svd};
    use nalgebra::DMatrix;

    #[test]
    fn passes_the_kit_around_every_direct_solver() {
        crate::testkit::check_solver(&Bounded::default());
        crate::testkit::check_solver(&Bounded::new(Svd::default()));
        crate::testkit::check_solver(&Bounded::new(NormalEquations::default()));
        assert!(
            Bounded::new(crate::Ridge::default())
                .solve(&LeastSquares::new(&DMatrix::identity(2, 2), &DVector::zeros(2)))
                .is_err()
        );
    }

    /// Many sizes and widths; the conditions are checked on the rows, to 1e-7 and in fact to round-off.
    #[test]
    fn optimality_conditions_hold_on_the_rows() {
        for seed in 0..30_usize {
            let (m, p) = (40 + 3 * seed, 4 + seed);
            let wave = |i: usize, j: usize| ((i * 19 + j * 31 + seed * 7 + i * j) as f64 * 0.77).sin();
            let a = DMatrix::from_fn(m, p, |i, j| wave(i, j) * 10f64.powi((j % 7) as i32 - 3));
            let y = DVector::from_fn(m, |i, _| 3.0 * wave(i, p + 3));
            let free = PivotedQr::default().solve(&LeastSquares::new(&a, &y)).unwrap().x;
            let mut bounds = Bounds::free(p);
            for j in 0..p {
                let half = 0.5 * free[j].abs();
                bounds = match j % 4 {
                    0 => bounds.with(j, -half, half),
                    1 => bounds.with(j, 0.0, f64::INFINITY),
                    2 => bounds.with(j, 0.1 * half, 0.1 * half),
                    _ => bounds,
                };
            }
            let s = Bounded::default().solve(&LeastSquares::new(&a, &y).with_bounds(&bounds)).unwrap();
            assert_eq!(s.status, Status::Converged, "seed {seed}");
            assert!(bounds.contains(s.x.as_slice()));
            let g = a.tr_mul(&(&a * &s.x - &y));
            for j in 0..p {
                let relative = g[j] / a.column(j).norm() / y.norm();
                assert!(s.x[j] <= bounds.lower[j] || relative < 1e-12, "seed {seed} column {j}: {relative}");
                assert!(s.x[j] >= bounds.upper[j] || relative > -1e-12, "seed {seed} column {j}: {relative}");
            }
        }
    }

    #[test]
    fn a_zero_column_goes_to_the_point_nearest_zero() {
        let mut a = DMatrix::from_fn(10, 3, |i, j| ((i + 2 * j) as f64).sin());
        a.column_mut(1).fill(0.0);
        let bounds = Bounds::free(3).with(1, 2.0, 5.0).with(0, 100.0, 200.0);
        let y = DVector::from_element(10, 1.0);
        let s = Bounded::default().solve(&LeastSquares::new(&a, &y).with_bounds(&bounds)).unwrap();
        assert!(bounds.contains(s.x.as_slice()) && (s.x[1] - 2.0).abs() < 1e-15);
    }
}
