//! Singular value decomposition of a small matrix, M = U diag(d) Vᵀ, d largest first.

use super::{copy_out, tame, tamed};
use crate::SolveError;
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::svd::{ComputeSvdVectors, svd as faer_svd, svd_scratch};
use faer::{Mat, Par};
use nalgebra::DMatrix;

/// Thin singular value decomposition.
#[derive(Debug)]
pub(crate) struct Svd {
    /// m × min(m, n).
    pub u: DMatrix<f64>,
    /// min(m, n), largest first.
    pub d: Vec<f64>,
    /// n × min(m, n).
    pub v: DMatrix<f64>,
}

/// Thin singular value decomposition of `m`.
pub(crate) fn svd(m: &DMatrix<f64>) -> Result<Svd, SolveError> {
    decompose(m, true)
}

/// Singular values alone.
pub(crate) fn singular_values(m: &DMatrix<f64>) -> Result<Vec<f64>, SolveError> {
    Ok(decompose(m, false)?.d)
}

fn decompose(m: &DMatrix<f64>, vectors: bool) -> Result<Svd, SolveError> {
    let (rows, cols) = m.shape();
    let size = rows.min(cols);
    let want = if vectors { ComputeSvdVectors::Thin } else { ComputeSvdVectors::No };
    let (mut u, mut v) = (Mat::zeros(rows, size), Mat::zeros(cols, size));
    if size == 0 {
        return Ok(Svd { u: DMatrix::zeros(rows, 0), d: Vec::new(), v: DMatrix::zeros(cols, 0) });
    }
    let by = tame(m);
    let mut d = Diag::zeros(size);
    let need = svd_scratch::<f64>(rows, cols, want, want, Par::Seq, Default::default());
    faer_svd(
        tamed(m, by).as_ref(),
        d.as_mut(),
        vectors.then(|| u.as_mut()),
        vectors.then(|| v.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(need)),
        Default::default(),
    )
    .map_err(|_| SolveError::Breakdown { what: "singular value decomposition", rows, columns: cols })?;
    let values: Vec<f64> = d.column_vector().iter().map(|d| d / by).collect();
    if values.iter().any(|d| !d.is_finite()) {
        return Err(SolveError::Breakdown { what: "singular value decomposition", rows, columns: cols });
    }
    Ok(Svd { u: copy_out(u.as_ref()), d: values, v: copy_out(v.as_ref()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rebuilds_the_matrix_at_any_scale() {
        for scale in [1e-300, 1.0, 1e200] {
            let m = DMatrix::from_fn(5, 3, |i, j| scale * ((i * 3 + j * j) as f64).sin());
            let s = svd(&m).unwrap();
            let back =
                &s.u * DMatrix::from_fn(3, 3, |i, j| if i == j { s.d[i] } else { 0.0 }) * s.v.transpose();
            assert!((back / scale - &m / scale).norm() < 1e-14, "{scale}");
            assert!(s.d.windows(2).all(|w| w[0] >= w[1]));
            assert_eq!(singular_values(&m).unwrap().len(), 3);
        }
    }
}
