//! Column-pivoted QR of a small matrix.
//!
//! M Π = Q [R₁; 0],  |R₁₁| ≥ |R₂₂| ≥ …
//!
//! Source: Businger and Golub (1965). faer's version is unblocked, so it is only ever given a triangle of p rows.
//! It returns finite nonsense on NaN: callers have checked their input.

use super::{copy_out, tame, tamed};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::householder::{
    apply_block_householder_sequence_transpose_on_the_left_in_place_scratch as apply_scratch,
    apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj as apply_transpose,
};
use faer::linalg::qr::col_pivoting::factor::{qr_in_place, qr_in_place_scratch};
use faer::linalg::qr::no_pivoting::factor::recommended_block_size;
use faer::{Conj, Mat, Par};
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
}
