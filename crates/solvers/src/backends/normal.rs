//! Normal equations with a guard.
//!
//! G = Bᵀ B,  G x̃ = Bᵀ b,  then once more  G δ = Bᵀ (b − B x̃),  with B = W^{1/2} A S, b = W^{1/2} y, x = S (x̃ + δ)
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | G = L Lᵀ | Gram matrix of the scaled, weighted columns | p × p |
//! | S | column scale | p × p, diagonal |
//!
//! Source: Björck, *Numerical Methods for Least Squares Problems*, §2.2 and §6.6. The Gram matrix squares the condition
//! number, so it cannot see singular values below about 1e-8. While those of L stay above 1 / `condition_limit` they
//! are certain, and the rank is full. Otherwise the rank and the columns to keep come from a pivoted QR, and the Gram
//! matrix is used on these columns if it can be; if not, QR solves and `SolverInfo::fallback` records it.

use crate::accumulator::Factor;
use crate::dense::{cholesky, gram, norm, singular_values, solve_upper, solve_upper_transposed};
use crate::solver::status_of_rank;
use crate::{Fallback, LeastSquares, Need, RankRule, Solution, SolveError, Solver, decide_rank};
use nalgebra::{DMatrix, DVector};

/// Gram matrix, Cholesky, one refinement against the rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalEquations {
    /// Rule of the pivoted QR that is used when the Gram matrix is too ill conditioned.
    pub rank: RankRule,
    /// Highest condition number of the scaled columns that the Gram matrix is trusted with; at most 1e8.
    pub condition_limit: f64,
}

impl Default for NormalEquations {
    fn default() -> Self {
        Self { rank: RankRule::Default, condition_limit: 1e7 }
    }
}

impl NormalEquations {
    /// Refuses options out of range.
    pub fn validate(&self) -> Result<(), SolveError> {
        if !(1.0..=1e8).contains(&self.condition_limit) {
            let value = self.condition_limit;
            return Err(SolveError::BadOption {
                option: "condition_limit",
                value,
                expected: "between 1 and 1e8",
            });
        }
        self.rank.validate()
    }
}

impl Solver for NormalEquations {
    fn name(&self) -> &str {
        "normal"
    }

    fn supports(&self, need: Need) -> bool {
        matches!(need, Need::RankDeficient | Need::Weights | Need::Unpenalised)
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        self.validate()?;
        problem.admit(self)?;
        let rows = Rows::of(problem);
        let p = problem.columns();
        let mut g = DMatrix::zeros(p, p);
        gram(&mut g, &rows.b);

        let all: Vec<usize> = (0..p).collect();
        let mut why = Fallback::IndefiniteGram;
        if let Some(upper) = cholesky(g.clone()) {
            let values = singular_values(&upper)?;
            let condition = condition_of(&values);
            if condition <= self.condition_limit {
                let mut solution = rows.solve(problem, &upper, &all, p);
                solution.info.rank_decision = Some(decide_rank(&values, problem.rows(), p, self.rank));
                solution.info.singular_values = Some(values);
                solution.info.condition = (p > 0).then_some(condition);
                return Ok(solution);
            }
            why = Fallback::IllConditionedGram { condition, limit: self.condition_limit };
        }

        let factor = Factor::of_valid(problem);
        let mut by_qr =
            problem.with_true_residual(factor.solve_pivoted(0, problem.column_scale(), self.rank)?);
        let kept = by_qr.info.kept.clone().unwrap_or_default();
        let scaled = factor.scaled(&rows.scale).select_columns(&kept);
        let condition = condition_of(&singular_values(&scaled)?);
        let part = DMatrix::from_fn(kept.len(), kept.len(), |i, j| g[(kept[i.max(j)], kept[i.min(j)])]);
        if condition > self.condition_limit {
            why = Fallback::IllConditionedGram { condition, limit: self.condition_limit };
        } else if let Some(upper) = cholesky(part) {
            let mut solution = rows.solve(problem, &upper, &kept, p);
            solution.info.rank_decision = by_qr.info.rank_decision;
            solution.info.singular_values = by_qr.info.singular_values;
            solution.info.condition = (!kept.is_empty()).then_some(condition);
            return Ok(solution);
        }
        by_qr.info.fallback = Some(why);
        Ok(by_qr)
    }
}

fn condition_of(values: &[f64]) -> f64 {
    match (values.first(), values.last()) {
        (Some(top), Some(low)) => top / low,
        _ => 1.0,
    }
}

/// The scaled, weighted rows.
struct Rows {
    b: DMatrix<f64>,
    y: DVector<f64>,
    scale: Vec<f64>,
}

impl Rows {
    fn of(problem: &LeastSquares<'_>) -> Self {
        let mut b = problem.a.clone();
        let mut y = problem.y.clone();
        if let Some(weights) = problem.weights {
            let roots: Vec<f64> = weights.iter().map(|w| w.sqrt()).collect();
            b.column_iter_mut().for_each(|mut c| c.iter_mut().zip(&roots).for_each(|(v, r)| *v *= r));
            y.iter_mut().zip(&roots).for_each(|(v, r)| *v *= r);
        }
        let inverse = |n: f64| if n >= f64::MIN_POSITIVE { 1.0 / n } else { 1.0 };
        let mut scale = match problem.scale {
            Some(s) => s.to_vec(),
            None => b.column_iter().map(|c| inverse(norm(c.as_slice()))).collect(),
        };
        // One common factor so that no square leaves the range.
        let top = b.column_iter().zip(&scale).fold(0.0_f64, |t, (c, s)| t.max(c.amax() * s));
        let common = inverse(top);
        scale.iter_mut().for_each(|s| *s *= common);
        b.column_iter_mut().zip(&scale).for_each(|(mut c, s)| c *= *s);
        Self { b, y, scale }
    }

    fn solve(&self, problem: &LeastSquares<'_>, upper: &DMatrix<f64>, kept: &[usize], p: usize) -> Solution {
        let columns = if kept.len() == p { None } else { Some(self.b.select_columns(kept)) };
        let b = columns.as_ref().unwrap_or(&self.b);
        let step = |r: &DVector<f64>| {
            let moments = b.tr_mul(r);
            solve_upper(upper, solve_upper_transposed(upper, moments.as_slice()).as_slice())
        };
        let mut inner = step(&self.y);
        inner += step(&(&self.y - b * &inner));
        let mut x = DVector::zeros(p);
        kept.iter().zip(inner.iter()).for_each(|(&j, v)| x[j] = v * self.scale[j]);
        let mut solution = Solution::new(problem, x, kept.len(), status_of_rank(kept.len(), p));
        solution.info.kept = Some(kept.to_vec());
        solution.info.iterations = 1;
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PivotedQr;

    #[test]
    fn passes_the_kit() {
        crate::testkit::check_solver(&NormalEquations::default());
    }

    /// Columns with singular values from 1 down to 1 / condition.
    fn conditioned(condition: f64) -> (DMatrix<f64>, DVector<f64>) {
        let (m, p) = (200, 8);
        let wave = |i: usize, j: usize| {
            ((i * 7 + 3) as f64 * (j + 1) as f64 * 0.37).sin() + 0.3 * ((i * j) as f64).cos()
        };
        let q = DMatrix::from_fn(m, p, wave).qr().q();
        let v = DMatrix::from_fn(p, p, wave).qr().q();
        let d =
            DMatrix::from_fn(
                p,
                p,
                |i, j| if i == j { condition.powf(-(i as f64) / (p - 1) as f64) } else { 0.0 },
            );
        (q * d * v, DVector::from_fn(m, |i, _| (i as f64 * 0.11).sin()))
    }

    #[test]
    fn residual_agrees_with_qr_while_the_guard_lets_it() {
        for exponent in 1..=6 {
            let (a, y) = conditioned(10f64.powi(exponent));
            let problem = LeastSquares::new(&a, &y);
            let normal = NormalEquations::default().solve(&problem).unwrap();
            let qr = PivotedQr::default().solve(&problem).unwrap();
            assert!(normal.info.fallback.is_none(), "1e{exponent}");
            let (n, q) = (normal.info.residual_norm, qr.info.residual_norm);
            assert!((n - q).abs() < 1e-9 * q, "1e{exponent}: {n} {q}");
        }
    }

    #[test]
    fn beyond_the_guard_qr_answers_and_the_info_says_so() {
        let (a, y) = conditioned(1e10);
        let problem = LeastSquares::new(&a, &y);
        let s = NormalEquations::default().solve(&problem).unwrap();
        assert!(
            matches!(s.info.fallback, Some(Fallback::IllConditionedGram { condition, .. }) if condition > 1e7)
        );
        assert_eq!(s.x, PivotedQr::default().solve(&problem).unwrap().x);
        assert!(NormalEquations { condition_limit: 1e12, ..Default::default() }.solve(&problem).is_err());
    }
}
