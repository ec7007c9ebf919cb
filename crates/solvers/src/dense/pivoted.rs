//! Column-pivoted QR of a small matrix.
//!
//! M Π = Q [R₁; 0],  |R₁₁| ≥ |R₂₂| ≥ …
//!
//! Source: Businger and Golub (1965). faer's version is unblocked, so it is only ever given a triangle of p rows.
//! It returns finite nonsense on NaN: callers have checked their input.

use super::{Reflectors, copy_out, fold, gram, norm, pivoted_cholesky, tame, tamed};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::householder::{
    apply_block_householder_sequence_transpose_on_the_left_in_place_scratch as apply_scratch,
    apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj as apply_transpose,
};
use faer::linalg::qr::col_pivoting::factor::{qr_in_place, qr_in_place_scratch};
use faer::linalg::qr::no_pivoting::factor::recommended_block_size;
use faer::{Conj, Mat, MatMut, Par};
use nalgebra::DMatrix;

/// A pivoted QR with Qᵀ already applied to the right-hand sides.
pub(crate) struct Pivoted {
    /// Upper trapezoidal, min(m, n) × n, columns in pivot order.
    pub r: DMatrix<f64>,
    /// Qᵀ Z, min(m, n) × k.
    pub z: DMatrix<f64>,
    /// Column of the original matrix at each place.
    pub order: Vec<usize>,
}

impl Pivoted {
    /// |R_kk|, largest first.
    pub fn pivots(&self) -> Vec<f64> {
        (0..self.r.nrows()).map(|k| self.r[(k, k)].abs()).collect()
    }
}

/// The same of a square matrix by a cheaper way, where it can be sure: the order of the columns is that of the Gram matrix's pivots, and the
/// reflections that follow are blocked. What they find is as it is with pivots chosen column by column: the diagonal of what is kept,
/// and behind it the longest column of what is not, all from orthogonal transformations. None where kept and dropped lie too near each other
/// for the Gram matrix to have put them in order.
pub(crate) fn ordered_qr(m: &DMatrix<f64>, z: &DMatrix<f64>) -> Option<(Pivoted, f64)> {
    /// Squares of the columns' lengths below which the Gram matrix sees nothing, and how far both sides have to be from it.
    const APART: f64 = 1e3;
    let n = m.ncols();
    let mut g = DMatrix::zeros(n, n);
    gram(&mut g, m);
    let most = g.diagonal().max();
    if !(most.is_finite() && most > 0.0) {
        return None;
    }
    let found = pivoted_cholesky(g, 0.1 * n as f64 * f64::EPSILON * most);
    let rank = found.pivots.len();
    let width = n + z.ncols();
    let mut block = DMatrix::zeros(m.nrows(), width);
    found.order.iter().enumerate().for_each(|(to, &from)| block.set_column(to, &m.column(from)));
    (0..z.ncols()).for_each(|j| block.set_column(n + j, &z.column(j)));
    let mut top = DMatrix::zeros(rank, width);
    if rank > 0 {
        fold(
            MatMut::from_column_major_slice_mut(top.as_mut_slice(), rank, width),
            MatMut::from_column_major_slice_mut(block.as_mut_slice(), m.nrows(), width),
            &mut Reflectors::default(),
        );
    }
    let least = (0..rank).fold(f64::INFINITY, |least, k| least.min(top[(k, k)].abs()));
    let rest = (rank..n).fold(0.0_f64, |most, j| most.max(norm(block.column(j).as_slice())));
    if rank < n && least < APART * rest {
        return None;
    }
    // Nothing dropped: what is small might still have hidden behind the order.
    if rank == n && least * least < APART * n as f64 * f64::EPSILON * most {
        return None;
    }
    let z = top.columns(n, z.ncols()).into_owned();
    Some((Pivoted { r: top.columns(0, n).into_owned(), z, order: found.order }, rest))
}

/// Pivoted QR of `m`, applied to `z`.
pub(crate) fn pivoted_qr(m: &DMatrix<f64>, z: &DMatrix<f64>) -> Pivoted {
    let (rows, cols) = m.shape();
    let size = rows.min(cols);
    if size == 0 {
        return Pivoted {
            r: DMatrix::zeros(0, cols),
            z: DMatrix::zeros(0, z.ncols()),
            order: (0..cols).collect(),
        };
    }
    let by = tame(m);
    let mut qr = tamed(m, by);
    let block = recommended_block_size::<f64>(rows, cols);
    let mut coeff = Mat::zeros(block, size);
    let (mut order, mut inverse) = (vec![0_usize; cols], vec![0_usize; cols]);
    let need = qr_in_place_scratch::<usize, f64>(rows, cols, block, Par::Seq, Default::default());
    qr_in_place(
        qr.as_mut(),
        coeff.as_mut(),
        &mut order,
        &mut inverse,
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(need)),
        Default::default(),
    );
    let mut rhs = tamed(z, 1.0);
    let need = apply_scratch::<f64>(rows, block, z.ncols());
    apply_transpose(
        qr.as_ref().subcols(0, size),
        coeff.as_ref(),
        Conj::No,
        rhs.as_mut(),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(need)),
    );
    let r = DMatrix::from_fn(size, cols, |i, j| if i <= j { qr[(i, j)] / by } else { 0.0 });
    Pivoted { r, z: copy_out(rhs.as_ref().subrows(0, size)), order }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    #[test]
    fn rebuilds_the_matrix_and_orders_the_pivots() {
        let m = DMatrix::from_fn(6, 4, |i, j| {
            ((i * 7 + j * 3) % 5) as f64 + if j == 2 { 1e-9 * i as f64 } else { 0.0 }
        });
        let p = pivoted_qr(&m, &DMatrix::identity(6, 6));
        let back = p.z.transpose() * &p.r;
        for (place, &column) in p.order.iter().enumerate() {
            assert!((back.column(place) - m.column(column)).norm() < 1e-13);
        }
        assert!(p.pivots().windows(2).all(|w| w[0] >= w[1] * (1.0 - 1e-12)));
    }

    #[test]
    fn the_order_of_the_gram_matrix_finds_the_same_rank_or_says_nothing() {
        let value = |i: usize, j: usize| ((i * 7 + j * j * 3 + i * j) as f64 * 0.37).sin();
        let mut m = DMatrix::from_fn(70, 40, value);
        for k in 30..40 {
            let sum = m.column(k - 30) * 0.5 - m.column(k - 20);
            m.set_column(k, &sum);
        }
        let z = DMatrix::from_fn(70, 1, |i, _| value(i, 99));
        let (found, rest) = ordered_qr(&m, &z).unwrap();
        let want = pivoted_qr(&m, &z);
        assert_eq!(found.r.nrows(), 30);
        assert!(rest < 1e-13 && want.pivots()[30] < 1e-13 && want.pivots()[29] > 1e-3);
        // The same least squares: the part of z that the columns reach.
        let reached = want.z.rows(0, 30).norm();
        assert!((found.z.norm() - reached).abs() < 1e-12);
        // A column that is another one but for 1e-8 is beyond what the Gram matrix sees, and the reflections show what it was.
        let near = m.column(1) + DVector::from_fn(70, |i, _| 1e-8 * value(i, 77));
        m.set_column(35, &near);
        assert!(ordered_qr(&m, &z).is_none_or(|(_, rest)| rest > 1e-9));
    }
}
