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

use crate::dense::{inverse_gram, norm, singular_values};
use crate::problem::check_len;
use crate::{RankDecision, RankRule, SolveError, decide_rank};
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

    /// (AᵀA)⁻¹, from the inverse of the triangle and never from a Gram matrix; none where the triangle has lost rank.
    pub fn inverse_gram(&self) -> Option<DMatrix<f64>> {
        if (0..self.columns()).any(|k| self.r[(k, k)] == 0.0) {
            return None;
        }
        Some(inverse_gram(&self.r))
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
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::accumulator::Triangular;

    /// Column 3 = column 0 − 2 · column 1, column 4 is zero, column 2 is tiny.
    pub(in crate::accumulator) fn deficient() -> (DMatrix<f64>, DVector<f64>, Factor) {
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
    fn the_inverse_of_the_gram_matrix_is_one() {
        let a = DMatrix::from_fn(40, 6, |i, j| ((i * 13 + j * 29 + i * j) as f64 * 0.61).sin());
        let mut t = Triangular::new(6, 0);
        t.update(&a, &DMatrix::zeros(40, 0)).unwrap();
        let inverse = t.finish().inverse_gram().unwrap();
        assert!((a.tr_mul(&a) * inverse - DMatrix::identity(6, 6)).amax() < 1e-12);
        assert!(deficient().2.inverse_gram().is_none(), "a zero column");
    }
}
