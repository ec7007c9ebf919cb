//! Fewer unknowns, and the directions in which the rest are determined: without going back to the rows.
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | R diag(s) = U diag(d) Vᵀ | singular value decomposition | p × p | that of A x |
//! | d_k | `values` | p | whitened: 1/d_k is the standard deviation of x along V_k, in units of s |
//! | (Uᵀ z)_k | `projections` | p | whitened: the estimate along V_k in its standard deviations |

use super::{ColumnScale, Factor, Triangular};
use crate::SolveError;
use crate::dense::svd;
use nalgebra::DMatrix;

/// Directions of the scaled unknowns, best determined first.
#[derive(Debug, Clone, PartialEq)]
pub struct Directions {
    /// Singular values d of the scaled factor.
    pub values: Vec<f64>,
    /// Directions V, one a column, orthonormal in the scaled unknowns.
    pub vectors: DMatrix<f64>,
    /// Uᵀ z of the first right-hand side.
    pub projections: Vec<f64>,
}

impl Factor {
    /// The factor of the same rows with these columns alone.
    ///
    /// # Errors
    /// When a column does not exist.
    pub fn restricted(&self, columns: &[usize]) -> Result<Factor, SolveError> {
        if let Some(&found) = columns.iter().find(|&&c| c >= self.columns()) {
            return Err(SolveError::Shape {
                what: "a column of the factor",
                expected: self.columns(),
                found,
            });
        }
        let mut inner = Triangular::new(columns.len(), self.z.ncols());
        inner.update(&self.r.select_columns(columns), &self.z)?;
        let mut factor = inner.finish();
        factor.rss.iter_mut().zip(&self.rss).for_each(|(rss, more)| *rss += more);
        factor.rows = self.rows;
        factor.resolution = self.resolution;
        Ok(factor)
    }

    /// Its directions, best determined first.
    ///
    /// # Errors
    /// When the decomposition fails.
    pub fn directions(&self, scale: ColumnScale<'_>) -> Result<Directions, SolveError> {
        let parts = svd(&self.scaled(&self.multipliers(scale)?))?;
        let projections = if self.z.ncols() == 0 {
            vec![0.0; parts.d.len()]
        } else {
            parts.u.tr_mul(&self.z.column(0)).as_slice().to_vec()
        };
        Ok(Directions { values: parts.d, vectors: parts.v, projections })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    #[test]
    fn a_restricted_factor_is_that_of_the_columns() {
        let a = DMatrix::from_fn(30, 5, |i, j| ((i * 7 + j * 3 + i * j) % 13) as f64 - 6.0);
        let y = DMatrix::from_fn(30, 1, |i, _| (i % 5) as f64);
        let mut whole = Triangular::new(5, 1);
        whole.update(&a, &y).unwrap();
        let part = whole.finish().restricted(&[3, 1]).unwrap();
        let columns = a.select_columns(&[3, 1]);
        let mut direct = Triangular::new(2, 1);
        direct.update(&columns, &y).unwrap();
        let direct = direct.finish();
        assert!((&part.r - &direct.r).amax() < 1e-12);
        assert!((part.rss[0] - direct.rss[0]).abs() < 1e-10);
        let x = DVector::from_column_slice(&[0.3, -0.2]);
        let residual = (&columns * &x - y.column(0)).norm();
        assert!((part.residual_norm(0, &x) - residual).abs() < 1e-10);
    }

    #[test]
    fn directions_rebuild_the_least_squares_answer() {
        let a = DMatrix::from_fn(20, 3, |i, j| ((i * 5 + j * 7 + i * i * j) % 11) as f64 - 5.0);
        let y = DMatrix::from_fn(20, 1, |i, _| (i % 7) as f64);
        let mut whole = Triangular::new(3, 1);
        whole.update(&a, &y).unwrap();
        let turned = whole.finish().directions(ColumnScale::Unit).unwrap();
        let along = DVector::from_fn(3, |k, _| turned.projections[k] / turned.values[k]);
        let x = &turned.vectors * along;
        assert!((a.tr_mul(&(&a * x - y))).amax() < 1e-9);
    }
}
