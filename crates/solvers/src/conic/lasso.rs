//! Lasso and elastic net.
//!
//! minimise ½ ‖W^{1/2} (A x − y)‖² + λ (α ‖x / s‖₁ + ½ (1 − α) ‖x / s‖²)
//!
//! optimal: g_j + λ(1−α) v_j = −λ α sign(v_j) where v_j ≠ 0, |g_j| ≤ λ α elsewhere
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | α | mix: 1 is the lasso, 0 a ridge | 1 |
//! | v | x / s | p |
//! | g | gradient of the squares along v | p |
//!
//! Source: Tibshirani (1996); Zou and Hastie (2005). The elastic net is a lasso on a triangle with √(λ(1−α)) below it.

use super::core::{Core, Inner};
use super::penalised::{Penalty, Strength, path, solve};
use super::program::Program;
use super::shifted::shifted;
use crate::{LeastSquares, Need, Solution, SolveError, Solver};
use nalgebra::{DMatrix, DVector};

/// Absolute values as penalty: few unknowns stay.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lasso {
    /// How λ is chosen.
    pub strength: Strength,
    /// Fit the unknowns that stay once more, without the penalty.
    pub refit: bool,
}

/// Absolute values and squares as penalty: columns that resemble each other stay together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElasticNet {
    /// How λ is chosen.
    pub strength: Strength,
    /// α in (0, 1]: share of the absolute values.
    pub mix: f64,
    /// Fit the unknowns that stay once more, without the penalty.
    pub refit: bool,
}

impl Default for ElasticNet {
    fn default() -> Self {
        Self { strength: Strength::default(), mix: 0.5, refit: false }
    }
}

impl Solver for Lasso {
    fn name(&self) -> &str {
        "lasso"
    }

    fn supports(&self, need: Need) -> bool {
        matches!(need, Need::RankDeficient | Need::Weights)
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        problem.admit(self)?;
        solve(problem, &Absolute { mix: 1.0 }, self.strength, self.refit)
    }
}

impl Solver for ElasticNet {
    fn name(&self) -> &str {
        "elastic_net"
    }

    fn supports(&self, need: Need) -> bool {
        matches!(need, Need::RankDeficient | Need::Weights)
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        problem.admit(self)?;
        solve(problem, &Absolute::new(self.mix)?, self.strength, self.refit)
    }
}

/// The lasso answers at `count` strengths from λ_max down to `least` λ_max.
pub fn lasso_path(problem: &LeastSquares<'_>, count: usize, least: f64) -> Result<Vec<Solution>, SolveError> {
    path(problem, &Absolute { mix: 1.0 }, count, least)
}

/// The elastic-net answers at `count` strengths from λ_max down to `least` λ_max.
pub fn elastic_net_path(
    problem: &LeastSquares<'_>,
    mix: f64,
    count: usize,
    least: f64,
) -> Result<Vec<Solution>, SolveError> {
    path(problem, &Absolute::new(mix)?, count, least)
}

struct Absolute {
    mix: f64,
}

impl Absolute {
    fn new(mix: f64) -> Result<Self, SolveError> {
        if mix > 0.0 && mix <= 1.0 {
            Ok(Self { mix })
        } else {
            Err(SolveError::BadOption { option: "mix", value: mix, expected: "above 0, at most 1" })
        }
    }
}

impl Penalty for Absolute {
    fn top(&self, core: &Core, omega: &[f64]) -> f64 {
        let g = core.gradient(&DVector::zeros(omega.len()));
        g.iter().zip(omega).fold(0.0, |top: f64, (g, w)| top.max(g.abs() / w)) / self.mix
    }

    fn solve(&self, core: &Core, omega: &[f64], lambda: f64) -> Inner {
        // λ of the problem is per size; the squares do not shrink with it.
        let (one, two) = (lambda * self.mix, lambda * core.size * (1.0 - self.mix));
        let p = omega.len();
        let (m, z) = below(core, omega, two);
        let mut program = Program::residual_form(&m, &z);
        for (k, w) in omega.iter().enumerate() {
            let t = program.variable(one * w);
            program.row(&[(k, 1.0), (t, -1.0)], 0.0);
            program.row(&[(k, -1.0), (t, -1.0)], 0.0);
        }
        if p > 0 {
            program.inequalities(2 * p);
        }
        let ended = program.run();
        if ended.v.is_empty() && p > 0 {
            return Inner::failed(ended.status, ended.iterations);
        }
        let limit: Vec<f64> = omega.iter().map(|w| one * w).collect();
        let raw = DVector::from_column_slice(&ended.v[..p]);
        let g = m.tr_mul(&(&m * &raw - &z));
        // A variable is zero when its own size is smaller than the slack of its gradient.
        let interior =
            DVector::from_fn(p, |k, _| if raw[k].abs() > limit[k] - g[k].abs() { raw[k] } else { 0.0 });
        let polished = active_set(&m, &z, &limit, &interior).map(|u| {
            let v = violation(&m, &z, &limit, &u);
            (u, v)
        });
        let v = violation(&m, &z, &limit, &interior);
        Inner::best((interior, v), polished, ended.status, ended.iterations)
    }
}

/// [M; √two diag(ω)] and [z; 0].
fn below(core: &Core, omega: &[f64], two: f64) -> (DMatrix<f64>, DVector<f64>) {
    if two <= 0.0 {
        return (core.m.clone(), core.z.clone());
    }
    let (rows, p) = core.m.shape();
    let m = DMatrix::from_fn(rows + p, p, |i, j| match i.checked_sub(rows) {
        None => core.m[(i, j)],
        Some(k) if k == j => two.sqrt() * omega[j],
        Some(_) => 0.0,
    });
    (m, core.z.clone().resize_vertically(rows + p, 0.0))
}

fn violation(m: &DMatrix<f64>, z: &DVector<f64>, limit: &[f64], u: &DVector<f64>) -> f64 {
    let g = m.tr_mul(&(m * u - z));
    (0..u.len()).fold(0.0, |worst: f64, k| {
        worst.max(if u[k] == 0.0 { g[k].abs() - limit[k] } else { (g[k] + limit[k] * u[k].signum()).abs() })
    })
}

/// With the signs known, the rest is least squares with a linear term; signs are corrected until they agree.
fn active_set(
    m: &DMatrix<f64>,
    z: &DVector<f64>,
    limit: &[f64],
    start: &DVector<f64>,
) -> Option<DVector<f64>> {
    const SETTLED: f64 = 1e-14;
    let p = start.len();
    let mut sign: Vec<f64> = start.iter().map(|u| if *u == 0.0 { 0.0 } else { u.signum() }).collect();
    for _ in 0..3 * p + 10 {
        let kept: Vec<usize> = (0..p).filter(|k| sign[*k] != 0.0).collect();
        let h = DVector::from_fn(kept.len(), |k, _| limit[kept[k]] * sign[kept[k]]);
        let solved = shifted(&m.select_columns(&kept), z, &h)?;
        let against = |k: usize| -solved[k] * sign[kept[k]];
        let worst =
            (0..kept.len()).filter(|k| against(*k) >= 0.0).max_by(|a, b| against(*a).total_cmp(&against(*b)));
        if let Some(k) = worst {
            sign[kept[k]] = 0.0;
            continue;
        }
        let mut u = DVector::zeros(p);
        kept.iter().zip(solved.iter()).for_each(|(k, v)| u[*k] = *v);
        let g = m.tr_mul(&(m * &u - z));
        let over = |k: usize| g[k].abs() - limit[k];
        let worst = (0..p)
            .filter(|k| sign[*k] == 0.0 && over(*k) > SETTLED)
            .max_by(|a, b| over(*a).total_cmp(&over(*b)));
        match worst {
            Some(k) => sign[k] = -g[k].signum(),
            None => return Some(u),
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GroupedFolds, Status};

    #[test]
    fn passes_the_kit() {
        for ratio in [0.5, 1e-2, 1e-6] {
            crate::testkit::check_solver(&Lasso { strength: Strength::Ratio(ratio), refit: false });
            crate::testkit::check_solver(&ElasticNet {
                strength: Strength::Ratio(ratio),
                mix: 0.4,
                refit: false,
            });
        }
        crate::testkit::check_solver(&Lasso { strength: Strength::Ratio(0.05), refit: true });
    }

    /// Ten of forty columns matter.
    fn sparse() -> (DMatrix<f64>, DVector<f64>, DVector<f64>, Vec<usize>) {
        let (m, p) = (240, 40);
        let wave = |i: usize, j: usize| ((i * 19 + j * 31 + i * j) as f64 * 0.77).sin();
        let a = DMatrix::from_fn(m, p, |i, j| wave(i, j) * 10f64.powi((j % 5) as i32 - 2));
        let truth = DVector::from_fn(p, |j, _| {
            if j % 4 == 0 { (1.0 + j as f64 / 20.0) / 10f64.powi((j % 5) as i32 - 2) } else { 0.0 }
        });
        let y = &a * &truth + DVector::from_fn(m, |i, _| 0.2 * wave(i * i, 77));
        (a, y, truth, (0..m).map(|i| i / 3).collect())
    }

    /// The conditions on the rows, in the unknowns of the problem.
    #[test]
    fn optimality_conditions_hold_on_the_rows_along_the_path() {
        let (a, y, _, _) = sparse();
        let problem = LeastSquares::new(&a, &y);
        for mix in [1.0, 0.3] {
            let solutions = elastic_net_path(&problem, mix, 12, 1e-4).unwrap();
            let mut before = 0;
            for s in &solutions {
                assert_eq!(s.status, Status::Converged);
                let lambda = s.info.strength.unwrap();
                let g = a.tr_mul(&(&a * &s.x - &y));
                for j in 0..40 {
                    let n = a.column(j).norm();
                    let inner = g[j] / n + lambda * (1.0 - mix) * s.x[j] * n;
                    let wrong = if s.x[j] == 0.0 {
                        inner.abs() - lambda * mix
                    } else {
                        (inner + lambda * mix * s.x[j].signum()).abs()
                    };
                    assert!(wrong < 1e-12 * y.norm(), "λ {lambda} column {j}: {wrong}");
                }
                assert!(s.info.optimality.unwrap() < 1e-12);
                let count = s.info.kept.as_ref().unwrap().len();
                assert!(count + 3 >= before);
                before = count;
            }
            assert_eq!(solutions[0].info.kept, Some(vec![]), "λ_max leaves nothing");
            assert!(before >= 30, "a weak penalty leaves nearly everything");
        }
    }

    #[test]
    fn cross_validation_finds_the_columns_and_the_refit_removes_the_bias() {
        let (a, y, truth, groups) = sparse();
        let problem = LeastSquares::new(&a, &y).with_row_groups(&groups);
        let folds = GroupedFolds { choice: crate::Choice::OneStandardError, ..Default::default() };
        let strength = Strength::GroupedCv { folds, count: 15, least: 1e-3 };
        let shrunk = Lasso { strength, refit: false }.solve(&problem).unwrap();
        let fitted = Lasso { strength, refit: true }.solve(&problem).unwrap();
        let wanted: Vec<usize> = (0..40).step_by(4).collect();
        let kept = fitted.info.kept.clone().unwrap();
        assert!(wanted.iter().all(|j| kept.contains(j)) && kept.len() <= 14, "{kept:?}");
        let size: Vec<f64> = a.column_iter().map(|c| c.norm()).collect();
        let error =
            |x: &DVector<f64>| (0..40).map(|j| ((x[j] - truth[j]) * size[j]).powi(2)).sum::<f64>().sqrt();
        assert!(error(&fitted.x) < 0.7 * error(&shrunk.x), "{} {}", error(&fitted.x), error(&shrunk.x));
    }

    #[test]
    fn bad_options_are_refused() {
        let (a, y, _, _) = sparse();
        let p = LeastSquares::new(&a, &y);
        assert!(Lasso { strength: Strength::Fixed(-1.0), refit: false }.solve(&p).is_err());
        assert!(ElasticNet { mix: 0.0, ..Default::default() }.solve(&p).is_err());
        assert!(lasso_path(&p, 1, 0.1).is_err());
    }
}
