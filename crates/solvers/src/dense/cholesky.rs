//! G = AᵀA and its Cholesky factor G = L Lᵀ.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;

/// Adds AᵀA to the lower triangle of `g`.
pub(crate) fn gram(g: &mut DMatrix<f64>, a: &DMatrix<f64>) {
    gram_of(g, a.nrows(), a.nrows(), a.as_slice());
}

/// The same of the first `rows` rows of columns that are `stride` numbers apart.
pub(crate) fn gram_of(g: &mut DMatrix<f64>, rows: usize, stride: usize, numbers: &[f64]) {
    let p = g.ncols();
    if p == 0 || rows == 0 {
        return;
    }
    let a = MatRef::from_column_major_slice_with_stride(numbers, rows, p, stride);
    matmul(
        MatMut::from_column_major_slice_mut(g.as_mut_slice(), p, p),
        BlockStructure::TriangularLower,
        Accum::Add,
        a.transpose(),
        BlockStructure::Rectangular,
        a,
        BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
}

/// Lᵀ (upper) of the symmetric matrix whose lower triangle is `g`; nothing if it is not positive definite.
pub(crate) fn cholesky(mut g: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let p = g.nrows();
    if p == 0 {
        return Some(g);
    }
    let need = cholesky_in_place_scratch::<f64>(p, Par::Seq, Default::default());
    cholesky_in_place(
        MatMut::from_column_major_slice_mut(g.as_mut_slice(), p, p),
        Default::default(),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(need)),
        Default::default(),
    )
    .ok()?;
    let upper = DMatrix::from_fn(p, p, |i, j| if i <= j { g[(j, i)] } else { 0.0 });
    upper.iter().all(|v| v.is_finite()).then_some(upper)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factor_of_a_gram_matrix() {
        let a = DMatrix::from_fn(9, 4, |i, j| ((i + 1) as f64 * (j + 2) as f64).cos());
        let mut g = DMatrix::zeros(4, 4);
        gram(&mut g, &a);
        let u = cholesky(g).unwrap();
        assert!((u.transpose() * &u - a.transpose() * &a).norm() < 1e-13);
        assert!(cholesky(DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0])).is_none());
    }
}
