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

use super::absolute::Absolute;
use super::penalised::{Strength, path, solve};
use crate::{LeastSquares, Need, Solution, SolveError, Solver};

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GroupedFolds, Status};
    use nalgebra::{DMatrix, DVector};

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
