//! G = AᵀA and its Cholesky factor G = L Lᵀ.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;

/// Adds AᵀA to the lower triangle of `g`.
pub fn gram(g: &mut DMatrix<f64>, a: &DMatrix<f64>) {
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

/// AᵀB of two matrices with as many rows.
pub fn cross(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(a.ncols(), b.ncols());
    if a.nrows() == 0 || out.is_empty() {
        return out;
    }
    let (rows, k, n) = (a.nrows(), a.ncols(), b.ncols());
    faer::linalg::matmul::matmul(
        MatMut::from_column_major_slice_mut(out.as_mut_slice(), k, n),
        Accum::Replace,
        MatRef::from_column_major_slice(a.as_slice(), rows, k).transpose(),
        MatRef::from_column_major_slice(b.as_slice(), rows, n),
        1.0,
        Par::Seq,
    );
    out
}

/// AB, m × n, of an m × k and a k × n matrix.
pub fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let (rows, k, n) = (a.nrows(), a.ncols(), b.ncols());
    let mut out = DMatrix::zeros(rows, n);
    if k == 0 || out.is_empty() {
        return out;
    }
    faer::linalg::matmul::matmul(
        MatMut::from_column_major_slice_mut(out.as_mut_slice(), rows, n),
        Accum::Replace,
        MatRef::from_column_major_slice(a.as_slice(), rows, k),
        MatRef::from_column_major_slice(b.as_slice(), k, n),
        1.0,
        Par::Seq,
    );
    out
}

/// Adds ± BᵀB to the lower triangle of `g`, B given row after row.
pub(crate) fn gram_of_rows(g: &mut DMatrix<f64>, rows: &[f64], sign: f64) {
    let p = g.ncols();
    let turned = MatRef::from_column_major_slice(rows, p, rows.len() / p.max(1));
    matmul(
        MatMut::from_column_major_slice_mut(g.as_mut_slice(), p, p),
        BlockStructure::TriangularLower,
        Accum::Add,
        turned,
        BlockStructure::Rectangular,
        turned.transpose(),
        BlockStructure::Rectangular,
        sign,
        Par::Seq,
    );
}

/// y − A x of rows given one after the other, each with its y behind its x.len() numbers.
pub(crate) fn residual_of_rows(x: &[f64], rows: &[f64]) -> Vec<f64> {
    let width = x.len() + 1;
    let count = rows.len() / width;
    let mut left: Vec<f64> = rows.chunks_exact(width).map(|row| row[width - 1]).collect();
    let turned = MatRef::from_column_major_slice(rows, width, count).subrows(0, x.len());
    let by = MatRef::from_column_major_slice(x, x.len(), 1);
    let into = MatMut::from_column_major_slice_mut(&mut left, count, 1);
    faer::linalg::matmul::matmul(into, Accum::Add, turned.transpose(), by, -1.0, Par::Seq);
    left
}

/// L of the leading p × p part of a matrix whose lower triangle is `g`; nothing if it is not positive definite to round-off.
pub fn cholesky_lower(mut g: DMatrix<f64>, p: usize) -> Option<DMatrix<f64>> {
    let stride = g.nrows();
    if p == 0 {
        return Some(g);
    }
    let floor = (0..p).fold(0.0_f64, |most, k| most.max(g[(k, k)])) * p as f64 * f64::EPSILON;
    let need = cholesky_in_place_scratch::<f64>(p, Par::Seq, Default::default());
    cholesky_in_place(
        MatMut::from_column_major_slice_with_stride_mut(g.as_mut_slice(), p, p, stride),
        Default::default(),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(need)),
        Default::default(),
    )
    .ok()?;
    (0..p).all(|k| g[(k, k)] * g[(k, k)] > floor).then_some(g)
}

/// L⁻¹ B, in place, with the leading part of L.
pub fn solve_lower_many(l: &DMatrix<f64>, b: &mut DMatrix<f64>) {
    let (p, columns) = b.shape();
    let l = MatRef::from_column_major_slice_with_stride(l.as_slice(), p, p, l.nrows());
    let b = MatMut::from_column_major_slice_mut(b.as_mut_slice(), p, columns);
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(l, b, Par::Seq);
}

/// R⁻¹ B, in place, with an upper triangle R.
pub fn solve_upper_many(r: &DMatrix<f64>, b: &mut DMatrix<f64>) {
    let (p, columns) = b.shape();
    let r = MatRef::from_column_major_slice(r.as_slice(), p, p);
    let b = MatMut::from_column_major_slice_mut(b.as_mut_slice(), p, columns);
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(r, b, Par::Seq);
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
