//! Ridge: squares plus a penalty on the scaled unknowns.
//!
//! minimise ‖W^{1/2} (A x − y)‖² + λ ‖S⁻¹ x‖²
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | S | column scale: the expected sizes, or one over the column norms | p × p, diagonal | that of x |
//! | λ | strength | 1 | 1 when rows are whitened |
//!
//! With rows whitened by their σ and S the prior standard deviations, λ = 1 is the maximum a posteriori. Source: Hansen,
//! *Discrete Inverse Problems* (2010), chapters 4–5; Golub, Heath and Wahba (1979) for generalized cross-validation.
//! Everything is computed on the singular values of the triangle: a new strength costs p² operations.

mod choose;
mod path;

pub use path::{RidgePath, ridge_path};

use crate::accumulator::Factor;
use crate::folds::GroupedFolds;
use crate::{LeastSquares, Need, Solution, SolveError, Solver};

/// Ridge regression.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ridge {
    /// How the strength is chosen.
    pub strength: RidgeStrength,
}

/// How the strength of a ridge is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum RidgeStrength {
    /// This λ.
    Fixed(f64),
    /// Least generalized cross-validation score: cheap, assumes independent rows.
    #[default]
    Gcv,
    /// Corner of the L-curve: needs no noise level and no independence, and decides the least sharply.
    LCurve,
    /// Least error on groups of rows left out.
    GroupedCv(GroupedFolds),
    /// λ = 1 with `LeastSquares::scale` as prior standard deviations; rows have to be whitened by their weights.
    Map,
}

impl Solver for Ridge {
    fn name(&self) -> &str {
        "ridge"
    }

    fn supports(&self, need: Need) -> bool {
        matches!(need, Need::RankDeficient | Need::Weights)
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        problem.admit(self)?;
        let factor = Factor::of_valid(problem);
        let path = RidgePath::new(&factor, problem.column_scale())?;
        let lambda = match self.strength {
            RidgeStrength::Fixed(lambda) if lambda >= 0.0 && lambda.is_finite() => lambda,
            RidgeStrength::Fixed(value) => {
                return Err(SolveError::BadOption {
                    option: "lambda",
                    value,
                    expected: "a finite number ≥ 0",
                });
            }
            RidgeStrength::Gcv => choose::gcv(&path),
            RidgeStrength::LCurve => choose::corner(&path),
            RidgeStrength::GroupedCv(folds) => choose::grouped(problem, &path, folds)?,
            RidgeStrength::Map if problem.scale.is_none() => {
                return Err(SolveError::Missing { solver: "ridge(map)", missing: "scale" });
            }
            RidgeStrength::Map => 1.0,
        };
        Ok(problem.with_true_residual(path.solution(lambda)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn every_choice_passes_the_kit() {
        use RidgeStrength::*;
        for strength in [Fixed(1e-3), Fixed(0.0), Gcv, LCurve, Map] {
            crate::testkit::check_solver(&Ridge { strength });
        }
    }

    /// Smooth columns whose singular values fall fast, and noise: the plain answer is far off.
    fn ill_posed() -> (DMatrix<f64>, DVector<f64>, DVector<f64>, Vec<usize>) {
        let (m, p) = (120, 12);
        let a = DMatrix::from_fn(m, p, |i, j| {
            (-((i as f64 / m as f64 - j as f64 / p as f64) / 0.25).powi(2)).exp()
        });
        let truth = DVector::from_fn(p, |j, _| (j as f64 * 0.5).sin());
        let noise = DVector::from_fn(m, |i, _| 0.01 * ((i * i * 7 + i * 3) as f64 * 1.7).sin());
        let y = &a * &truth + noise;
        (a, y, truth, (0..m).map(|i| i / 3).collect())
    }

    #[test]
    fn every_choice_beats_the_plain_answer_where_it_should() {
        let (a, y, truth, groups) = ill_posed();
        let problem = LeastSquares::new(&a, &y).with_row_groups(&groups);
        let error = |strength| (Ridge { strength }.solve(&problem).unwrap().x - &truth).norm() / truth.norm();
        let plain = error(RidgeStrength::Fixed(0.0));
        assert!(plain > 0.5, "{plain}");
        for s in
            [RidgeStrength::Gcv, RidgeStrength::LCurve, RidgeStrength::GroupedCv(GroupedFolds::default())]
        {
            assert!(error(s) < 0.5 * plain, "{s:?}: {} against {plain}", error(s));
        }
    }

    #[test]
    fn map_is_the_bayesian_mean() {
        let (a, y, _, _) = ill_posed();
        let prior: Vec<f64> = (0..12).map(|j| 0.5 + 0.1 * j as f64).collect();
        let weights = vec![1.0 / 0.01_f64.powi(2); 120];
        let problem = LeastSquares::new(&a, &y).with_weights(&weights).with_scale(&prior);
        let s = Ridge { strength: RidgeStrength::Map }.solve(&problem).unwrap();
        let precision = DMatrix::from_diagonal(&DVector::from_fn(12, |j, _| prior[j].powi(-2)));
        let gradient = a.tr_mul(&(&a * &s.x - &y)) * 1e4 + precision * &s.x;
        assert!(gradient.amax() < 1e-7 * a.tr_mul(&y).amax() * 1e4, "{}", gradient.amax());
        let bare = LeastSquares::new(&a, &y);
        assert!(matches!(
            Ridge { strength: RidgeStrength::Map }.solve(&bare),
            Err(SolveError::Missing { missing: "scale", .. })
        ));
    }
}
