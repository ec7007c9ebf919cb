//! The directions in which the unknowns are determined: without going back to the rows.
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | R diag(s) = U diag(d) Vᵀ | singular value decomposition | p × p | that of A x |
//! | d_k | `values` | p | whitened: 1/d_k is the standard deviation of x along V_k, in units of s |
//! | (Uᵀ z)_k | `projections` | p | whitened: the estimate along V_k in its standard deviations |

use super::{ColumnScale, Factor};
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
    use crate::Triangular;
    use nalgebra::DVector;

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
