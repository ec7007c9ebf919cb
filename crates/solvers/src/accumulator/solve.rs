//! Solutions from a factor: basic, shortest, ridge.
//!
//! minimise ‖R x − z‖² (+ λ ‖x / s‖²)
//!
//! Notation as in [`Factor`]. Source: Golub and Van Loan, §5.5 and §6.1.

use super::{ColumnScale, Factor};
use crate::dense::{ordered_qr, pivoted_qr, solve_upper, svd};
use crate::solver::status_of_rank;
use crate::{RankDecision, RankRule, Solution, SolveError, SolverInfo};
use nalgebra::DVector;

impl Factor {
    /// Basic solution of right-hand side `k` by pivoted QR: columns that depend on others get zero.
    pub fn solve_pivoted(
        &self,
        k: usize,
        scale: ColumnScale<'_>,
        rule: RankRule,
    ) -> Result<Solution, SolveError> {
        rule.validate()?;
        let s = self.multipliers(scale)?;
        let (scaled, z) = (self.scaled(&s), self.z.columns(k, 1).into_owned());
        let quick = ordered_qr(&scaled, &z).and_then(|(qr, rest)| {
            let mut pivots = qr.pivots();
            let rank = pivots.len();
            if rank < self.columns() {
                pivots.push(rest);
            }
            // The rule has to cut where the order did, and there alone.
            let decision = self.decide(&pivots, rule);
            (decision.rank == rank).then_some((qr, pivots, decision))
        });
        let (qr, pivots, decision) = quick.unwrap_or_else(|| {
            let qr = pivoted_qr(&scaled, &z);
            let pivots = qr.pivots();
            let decision = self.decide(&pivots, rule);
            (qr, pivots, decision)
        });
        let inner = solve_upper(&qr.r, &qr.z.as_slice()[..decision.rank]);
        let mut x = DVector::zeros(self.columns());
        for (place, value) in inner.iter().enumerate() {
            x[qr.order[place]] = value * s[qr.order[place]];
        }
        let mut kept = qr.order[..decision.rank].to_vec();
        kept.sort_unstable();
        Ok(self.solution(k, x, pivots, decision, Some(kept)))
    }

    /// Solution of right-hand side `k` of least norm in the scaled unknowns, by truncated SVD.
    pub fn solve_svd(
        &self,
        k: usize,
        scale: ColumnScale<'_>,
        rule: RankRule,
    ) -> Result<Solution, SolveError> {
        rule.validate()?;
        let s = self.multipliers(scale)?;
        let parts = svd(&self.scaled(&s))?;
        let decision = self.decide(&parts.d, rule);
        let turned = parts.u.tr_mul(&self.z.column(k));
        let inner = DVector::from_fn(decision.rank, |i, _| turned[i] / parts.d[i]);
        let mut x = parts.v.columns(0, decision.rank) * inner;
        x.iter_mut().zip(&s).for_each(|(x, s)| *x *= s);
        self.clear_zero_columns(&mut x);
        Ok(self.solution(k, x, parts.d, decision, None))
    }

    /// Zero for zero columns, to which the SVD gives round-off.
    pub(crate) fn clear_zero_columns(&self, x: &mut DVector<f64>) {
        for (x, n) in x.iter_mut().zip(self.column_norms()) {
            if n < f64::MIN_POSITIVE {
                *x = 0.0;
            }
        }
    }

    /// minimise ‖A x − y_k‖² + λ ‖x / s‖².
    pub fn solve_ridge(&self, k: usize, scale: ColumnScale<'_>, lambda: f64) -> Result<Solution, SolveError> {
        if !(lambda >= 0.0 && lambda.is_finite()) {
            return Err(SolveError::BadOption {
                option: "lambda",
                value: lambda,
                expected: "a finite number ≥ 0",
            });
        }
        let s = self.multipliers(scale)?;
        let parts = svd(&self.scaled(&s))?;
        let decision = self.decide(&parts.d, RankRule::Default);
        let turned = parts.u.tr_mul(&self.z.column(k));
        let inner =
            DVector::from_fn(decision.rank, |i, _| parts.d[i] * turned[i] / (parts.d[i].powi(2) + lambda));
        let mut x = parts.v.columns(0, decision.rank) * inner;
        x.iter_mut().zip(&s).for_each(|(x, s)| *x *= s);
        self.clear_zero_columns(&mut x);
        let used = parts.d[..decision.rank].iter().map(|d| d * d / (d * d + lambda)).sum();
        let mut solution = self.solution(k, x, parts.d, decision, None);
        solution.info.strength = Some(lambda);
        solution.info.effective_parameters = Some(used);
        Ok(solution)
    }

    fn solution(
        &self,
        k: usize,
        x: DVector<f64>,
        values: Vec<f64>,
        decision: RankDecision,
        kept: Option<Vec<usize>>,
    ) -> Solution {
        let condition = (decision.rank > 0).then(|| values[0] / decision.last_kept);
        let info = SolverInfo {
            residual_norm: self.residual_norm(k, &x),
            singular_values: Some(values),
            rank_decision: Some(decision),
            condition,
            kept,
            ..SolverInfo::default()
        };
        Solution { x, rank: decision.rank, status: status_of_rank(decision.rank, self.columns()), info }
    }
}

#[cfg(test)]
mod tests {
    use super::super::factor::tests::deficient;
    use super::*;

    #[test]
    fn both_solutions_are_optimal_and_the_svd_is_the_shorter() {
        let (a, y, f) = deficient();
        let basic = f.solve_pivoted(0, ColumnScale::Norms, RankRule::Default).unwrap();
        let short = f.solve_svd(0, ColumnScale::Norms, RankRule::Default).unwrap();
        let unit: Vec<f64> = f.multipliers(ColumnScale::Norms).unwrap();
        for s in [&basic, &short] {
            let gradient = a.tr_mul(&(&a * &s.x - &y));
            for j in 0..5 {
                assert!(gradient[j].abs() * unit[j] < 1e-13, "{gradient}");
            }
            assert!((s.info.residual_norm - (&a * &s.x - &y).norm()).abs() < 1e-13);
            assert_eq!(s.status, crate::Status::RankDeficient { rank: 3 });
        }
        let length = |x: &DVector<f64>| x.iter().zip(&unit).map(|(x, u)| (x / u).powi(2)).sum::<f64>();
        assert!(length(&short.x) <= length(&basic.x) + 1e-12);
        assert_eq!(basic.info.kept.unwrap().len(), 3);
    }

    #[test]
    fn ridge_meets_its_own_normal_equations() {
        let (a, y, f) = deficient();
        let scale = [1.0, 0.5, 2e8, 1.0, 3.0];
        let s = f.solve_ridge(0, ColumnScale::Given(&scale), 0.3).unwrap();
        let gradient = a.tr_mul(&(&a * &s.x - &y));
        for j in 0..5 {
            let total = gradient[j] + 0.3 * s.x[j] / scale[j].powi(2);
            assert!((total * scale[j]).abs() < 1e-12, "{j} {total}");
        }
        assert!(s.info.effective_parameters.unwrap() < 3.0);
        assert!(f.solve_ridge(0, ColumnScale::Unit, f64::NAN).is_err());
    }
}
