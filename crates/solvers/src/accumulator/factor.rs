//! What an accumulator ends in, and what follows from it without the rows.
//!
//! ‖A x − y‖² = ‖R x − z‖² + rss
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | R | upper triangle, diagonal ≥ 0 | p × p | that of A |
//! | z | Qᵀ y | p × k | that of y |
//! | rss | squares that no column reaches | k | that of y, squared |
//! | s | column scale: R diag(s) is what ranks are decided on | p | that of x |

use super::Triangular;
use crate::dense::{norm, pivoted_qr, singular_values, solve_upper, svd};
use crate::problem::check_len;
use crate::solver::status_of_rank;
use crate::{RankDecision, RankRule, Solution, SolveError, SolverInfo, decide_rank};
use nalgebra::{DMatrix, DVector};

/// By what the columns are multiplied before anything is decided.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum ColumnScale<'a> {
    /// One over their norms.
    #[default]
    Norms,
    /// Nothing.
    Unit,
    /// The expected sizes of the unknowns.
    Given(&'a [f64]),
}

/// Triangular factor of [A | Y] and what is left of Y.
#[derive(Debug, Clone, PartialEq)]
pub struct Factor {
    /// Upper triangle, p × p.
    pub r: DMatrix<f64>,
    /// Qᵀ Y, p × k.
    pub z: DMatrix<f64>,
    /// Squares of each right-hand side that no column reaches.
    pub rss: Vec<f64>,
    /// Number of rows that went in.
    pub rows: usize,
    /// Relative size below which singular values are round-off: ε for a triangle, √(p ε) for a Gram matrix.
    pub resolution: f64,
}

/// Directions that the rows do not determine.
#[derive(Debug, Clone, PartialEq)]
pub struct NullSpace {
    /// p × (p − rank), orthonormal, in the scaled unknowns: A diag(scale) basis = 0.
    pub basis: DMatrix<f64>,
    /// Scale of each unknown: `scale ∘ column` is a direction in the unknowns themselves.
    pub scale: Vec<f64>,
    /// Singular values of the scaled matrix.
    pub singular_values: Vec<f64>,
    /// How the rank was decided.
    pub decision: RankDecision,
}

impl Factor {
    /// Number of unknowns p.
    pub fn columns(&self) -> usize {
        self.r.ncols()
    }

    /// Norms of the columns of A.
    pub fn column_norms(&self) -> Vec<f64> {
        self.r.column_iter().map(|c| norm(c.as_slice())).collect()
    }

    /// The multipliers that a [`ColumnScale`] means here; 1 for a zero column.
    pub fn multipliers(&self, scale: ColumnScale<'_>) -> Result<Vec<f64>, SolveError> {
        match scale {
            ColumnScale::Unit => Ok(vec![1.0; self.columns()]),
            ColumnScale::Norms => Ok(self
                .column_norms()
                .iter()
                .map(|n| if *n >= f64::MIN_POSITIVE { 1.0 / n } else { 1.0 })
                .collect()),
            ColumnScale::Given(s) => {
                check_len("scale", self.columns(), s.len())?;
                match s.iter().position(|s| !s.is_finite() || *s <= 0.0) {
                    Some(column) => Err(SolveError::BadScale { column, value: s[column] }),
                    None => Ok(s.to_vec()),
                }
            }
        }
    }

    /// The factor of some of the columns.
    pub fn select(&self, columns: &[usize]) -> Self {
        let (p, k) = (columns.len(), self.z.ncols());
        let mut block = DMatrix::zeros(self.columns(), p + k);
        columns.iter().enumerate().for_each(|(to, from)| block.set_column(to, &self.r.column(*from)));
        (0..k).for_each(|j| block.set_column(p + j, &self.z.column(j)));
        let mut part = Triangular::new(p, k);
        part.take_block(&mut block);
        let mut factor = part.finish();
        factor.rss.iter_mut().zip(&self.rss).for_each(|(new, old)| *new += old);
        Self { rows: self.rows, resolution: self.resolution, ..factor }
    }

    /// R diag(s).
    pub fn scaled(&self, s: &[f64]) -> DMatrix<f64> {
        DMatrix::from_fn(self.columns(), self.columns(), |i, j| self.r[(i, j)] * s[j])
    }

    /// Singular values of A diag(s), largest first.
    pub fn singular_values(&self, scale: ColumnScale<'_>) -> Result<Vec<f64>, SolveError> {
        singular_values(&self.scaled(&self.multipliers(scale)?))
    }

    /// The rank of A diag(s), from its singular values.
    pub fn rank(&self, scale: ColumnScale<'_>, rule: RankRule) -> Result<RankDecision, SolveError> {
        rule.validate()?;
        Ok(self.decide(&self.singular_values(scale)?, rule))
    }

    /// A basis of the directions that the rows do not determine.
    pub fn null_space(&self, scale: ColumnScale<'_>, rule: RankRule) -> Result<NullSpace, SolveError> {
        rule.validate()?;
        let s = self.multipliers(scale)?;
        let parts = svd(&self.scaled(&s))?;
        let decision = self.decide(&parts.d, rule);
        let basis = parts.v.columns(decision.rank, self.columns() - decision.rank).into_owned();
        Ok(NullSpace { basis, scale: s, singular_values: parts.d, decision })
    }

    /// Basic solution of right-hand side `k` by pivoted QR: columns that depend on others get zero.
    pub fn solve_pivoted(
        &self,
        k: usize,
        scale: ColumnScale<'_>,
        rule: RankRule,
    ) -> Result<Solution, SolveError> {
        rule.validate()?;
        let s = self.multipliers(scale)?;
        let qr = pivoted_qr(&self.scaled(&s), &self.z.columns(k, 1).into_owned());
        let pivots = qr.pivots();
        let decision = self.decide(&pivots, rule);
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

    /// ‖A x − y_k‖.
    pub fn residual_norm(&self, k: usize, x: &DVector<f64>) -> f64 {
        norm((&self.r * x - self.z.column(k)).as_slice()).hypot(self.rss[k].sqrt())
    }

    /// The decision on these values, never finer than the resolution of this factor.
    pub(crate) fn decide(&self, values: &[f64], rule: RankRule) -> RankDecision {
        let decision = decide_rank(values, self.rows, self.columns(), rule);
        let least = values.first().copied().unwrap_or(0.0) * self.resolution;
        if decision.tolerance >= least {
            return decision;
        }
        decide_rank(values, self.rows, self.columns(), RankRule::Absolute(least))
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
    use super::*;
    use crate::accumulator::Triangular;

    /// Column 3 = column 0 − 2 · column 1, column 4 is zero, column 2 is tiny.
    fn deficient() -> (DMatrix<f64>, DVector<f64>, Factor) {
        let mut a = DMatrix::from_fn(60, 5, |i, j| ((i * 13 + j * 29 + i * j) as f64 * 0.61).sin());
        let dependent = a.column(0) - 2.0 * a.column(1);
        a.set_column(3, &dependent);
        a.column_mut(4).fill(0.0);
        a.column_mut(2).scale_mut(1e-9);
        let y = DVector::from_fn(60, |i, _| (i as f64 * 0.3).cos());
        let mut t = Triangular::new(5, 1);
        t.update(&a, &DMatrix::from_column_slice(60, 1, y.as_slice())).unwrap();
        (a, y, t.finish())
    }

    #[test]
    fn rank_and_null_space() {
        let (a, _, f) = deficient();
        let d = f.rank(ColumnScale::Norms, RankRule::Default).unwrap();
        assert!(d.rank == 3 && d.is_clear(), "{d:?}");
        let n = f.null_space(ColumnScale::Norms, RankRule::Default).unwrap();
        assert_eq!(n.basis.shape(), (5, 2));
        let directions = DMatrix::from_fn(5, 2, |i, j| n.basis[(i, j)] * n.scale[i]);
        assert!((a * directions).amax() < 1e-14);
    }

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
