//! Least squares with a linear term, by QR.
//!
//! minimise ½ ‖M u − z‖² + hᵀ u:   u = T⁻¹ (Qᵀ z − T⁻ᵀ h)  with M = Q T
//!
//! This is the smooth problem that is left once an active set is known. Columns that depend on others get zero: a
//! candidate, whose optimality the caller measures.

use crate::dense::{pivoted_qr, solve_upper, solve_upper_transposed};
use nalgebra::{DMatrix, DVector};

pub(super) fn shifted(m: &DMatrix<f64>, z: &DVector<f64>, h: &DVector<f64>) -> Option<DVector<f64>> {
    let p = m.ncols();
    if p == 0 {
        return Some(DVector::zeros(0));
    }
    let qr = pivoted_qr(m, &DMatrix::from_column_slice(z.len(), 1, z.as_slice()));
    let pivots = qr.pivots();
    let rank = pivots.iter().take_while(|d| **d > 1e-13 * pivots[0]).count();
    let order = &qr.order[..rank];
    let permuted: Vec<f64> = order.iter().map(|j| h[*j]).collect();
    let step = |b: &[f64], h: &[f64]| {
        let lift = solve_upper_transposed(&qr.r, h);
        let right: Vec<f64> = b.iter().zip(lift.iter()).map(|(b, l)| b - l).collect();
        solve_upper(&qr.r, &right)
    };
    let inner = step(&qr.z.as_slice()[..rank], &permuted);
    let mut u = DVector::zeros(p);
    order.iter().zip(inner.iter()).for_each(|(j, v)| u[*j] = *v);
    // One refinement on what is left of the gradient.
    let left = m.tr_mul(&(m * &u - z)) + h;
    let left: Vec<f64> = order.iter().map(|j| left[*j]).collect();
    let correction = step(&vec![0.0; rank], &left);
    order.iter().zip(correction.iter()).for_each(|(j, v)| u[*j] += *v);
    u.iter().all(|v| v.is_finite()).then_some(u)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_vanishes() {
        let m = DMatrix::from_fn(9, 4, |i, j| ((i * 5 + j * 3 + i * j) as f64).sin());
        let z = DVector::from_fn(9, |i, _| (i as f64).cos());
        let h = DVector::from_fn(4, |j, _| 0.1 * j as f64 - 0.2);
        let u = shifted(&m, &z, &h).unwrap();
        assert!((m.tr_mul(&(&m * &u - &z)) + h).amax() < 1e-14);
        let twice =
            shifted(&DMatrix::from_element(3, 2, 1.0), &DVector::from_element(3, 2.0), &DVector::zeros(2))
                .unwrap();
        assert!((twice.sum() - 2.0).abs() < 1e-15 && twice.min().abs() < 1e-15);
    }
}
