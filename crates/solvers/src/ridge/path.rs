//! The ridge answers of every strength, from one decomposition.
//!
//! x(λ) = S V diag(d / (d² + λ)) Uᵀ z,  with R S = U diag(d) Vᵀ
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | β = Uᵀ z | right-hand side along the left singular vectors | p |
//! | f_k = d_k² / (d_k² + λ) | filter; their sum is the effective number of parameters | p |

use crate::accumulator::{ColumnScale, Factor};
use crate::dense::{norm, svd};
use crate::solver::status_of_rank;
use crate::{LeastSquares, RankDecision, RankRule, Solution, SolveError, SolverInfo};
use nalgebra::{DMatrix, DVector};

/// All ridge answers of one problem.
#[derive(Debug, Clone)]
pub struct RidgePath {
    d: Vec<f64>,
    beta: DVector<f64>,
    v: DMatrix<f64>,
    pub(super) scale: Vec<f64>,
    /// The scale, zero for zero columns, to which the SVD gives round-off.
    mask: Vec<f64>,
    rss: f64,
    rows: usize,
    decision: RankDecision,
}

impl RidgePath {
    /// Decomposes the first right-hand side of a factor.
    pub fn new(factor: &Factor, scale: ColumnScale<'_>) -> Result<Self, SolveError> {
        let scale = factor.multipliers(scale)?;
        let parts = svd(&factor.scaled(&scale))?;
        let decision = factor.decide(&parts.d, RankRule::Default);
        let live = factor.column_norms().into_iter().map(|n| n >= f64::MIN_POSITIVE);
        let mask: Vec<f64> = scale.iter().zip(live).map(|(s, live)| if live { *s } else { 0.0 }).collect();
        let beta = parts.u.tr_mul(&factor.z.column(0));
        Ok(Self {
            d: parts.d,
            beta,
            v: parts.v,
            scale,
            mask,
            rss: factor.rss[0],
            rows: factor.rows,
            decision,
        })
    }

    fn filter(&self, k: usize, lambda: f64) -> f64 {
        if k < self.decision.rank { self.d[k].powi(2) / (self.d[k].powi(2) + lambda) } else { 0.0 }
    }

    /// x(λ) in the scaled unknowns.
    fn inner(&self, lambda: f64) -> DVector<f64> {
        let rank = self.decision.rank;
        let turned = DVector::from_fn(rank, |k, _| self.filter(k, lambda) * self.beta[k] / self.d[k]);
        self.v.columns(0, rank) * turned
    }

    /// x(λ).
    pub fn x(&self, lambda: f64) -> DVector<f64> {
        let mut x = self.inner(lambda);
        x.iter_mut().zip(&self.mask).for_each(|(x, s)| *x *= s);
        x
    }

    /// ‖W^{1/2} (A x(λ) − y)‖.
    pub fn residual_norm(&self, lambda: f64) -> f64 {
        let left: Vec<f64> =
            self.beta.iter().enumerate().map(|(k, b)| (1.0 - self.filter(k, lambda)) * b).collect();
        norm(&left).hypot(self.rss.sqrt())
    }

    /// ‖S⁻¹ x(λ)‖.
    pub fn solution_norm(&self, lambda: f64) -> f64 {
        let size = |k: usize| self.filter(k, lambda) * self.beta[k] / self.d[k];
        norm(&(0..self.decision.rank).map(size).collect::<Vec<_>>())
    }

    /// Effective number of parameters.
    pub fn effective_parameters(&self, lambda: f64) -> f64 {
        (0..self.d.len()).map(|k| self.filter(k, lambda)).sum()
    }

    /// Generalized cross-validation score m ‖r‖² / (m − Σ f)².
    pub fn gcv(&self, lambda: f64) -> f64 {
        let free = self.rows as f64 - self.effective_parameters(lambda);
        if free <= 0.0 {
            f64::INFINITY
        } else {
            self.rows as f64 * (self.residual_norm(lambda) / free).powi(2)
        }
    }

    /// `count` strengths from strongest to weakest, spaced evenly in their logarithm from beyond the
    /// square of the largest singular value to far below that of the smallest that counts.
    pub fn strengths(&self, count: usize) -> Vec<f64> {
        if self.decision.rank == 0 {
            return vec![0.0];
        }
        let top = self.d[0].powi(2).ln() + 2.0;
        let low = 2.0 * self.decision.last_kept.ln() - 18.0;
        (0..count).map(|k| (top + (low - top) * k as f64 / (count.max(2) - 1) as f64).exp()).collect()
    }

    /// The answer at λ.
    pub fn solution(&self, lambda: f64) -> Solution {
        let decision = self.decision;
        let info = SolverInfo {
            residual_norm: self.residual_norm(lambda),
            singular_values: Some(self.d.clone()),
            rank_decision: Some(decision),
            condition: (decision.rank > 0).then(|| self.d[0] / decision.last_kept),
            strength: Some(lambda),
            effective_parameters: Some(self.effective_parameters(lambda)),
            ..SolverInfo::default()
        };
        let status = status_of_rank(decision.rank, self.scale.len());
        Solution { x: self.x(lambda), rank: decision.rank, status, info }
    }
}

/// The ridge answer at each of `strengths`.
pub fn ridge_path(problem: &LeastSquares<'_>, strengths: &[f64]) -> Result<Vec<Solution>, SolveError> {
    let path = RidgePath::new(&Factor::of(problem)?, problem.column_scale())?;
    strengths
        .iter()
        .map(|&value| {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(SolveError::BadOption {
                    option: "lambda",
                    value,
                    expected: "a finite number ≥ 0",
                });
            }
            Ok(problem.with_true_residual(path.solution(value)))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_runs_from_zero_to_the_plain_answer() {
        let a = DMatrix::from_fn(50, 4, |i, j| ((i * (j + 2) + j) as f64 * 0.37).sin());
        let y = DVector::from_fn(50, |i, _| (i as f64 * 0.2).cos());
        let problem = LeastSquares::new(&a, &y);
        let strengths = [1e6, 1.0, 1e-3, 0.0];
        let path = ridge_path(&problem, &strengths).unwrap();
        for (s, lambda) in path.iter().zip(strengths) {
            let unit: Vec<f64> = a.column_iter().map(|c| c.norm()).collect();
            let g = a.tr_mul(&(&a * &s.x - &y));
            for j in 0..4 {
                assert!((g[j] / unit[j] + lambda * s.x[j] * unit[j]).abs() < 1e-12, "{lambda}");
            }
            let direct = problem.residual(&s.x).norm();
            assert!((s.info.residual_norm - direct).abs() < 1e-12);
        }
        assert!(path[0].x.norm() < 1e-4 && path.windows(2).all(|w| w[0].x.norm() <= w[1].x.norm()));
        assert!(ridge_path(&problem, &[-1.0]).is_err());
    }
}
