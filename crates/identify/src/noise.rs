//! How measurements scatter around a true model, and the whitening that makes all rows count alike.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | s | standard deviation that the instrument states for a component | m, rad |
//! | τ | `position_sd`, on top of s, for every row by itself | m |
//! | ρ | `visit_sd`, shared by all rows of one standstill: the robot's repeatability | m |
//! | ω | `orientation_sd`, on top of what is stated, for every row by itself | rad |
//!
//! The positions of one visit have, axis by axis, the covariance `V = diag(s² + τ²) + ρ² 1 1ᵀ`. With
//! `u = r / σ`, σ² = s² + τ² and `d = 1/σ`, whitening is `(I + ρ² d dᵀ)^{-1/2} u`, which is
//! `u − (1 − 1/√(1 + ρ²|d|²)) d (d·u) / |d|²` (Golub and Van Loan, §2.1.4, the rank-one formula).

/// By how much what the rows of a visit share is taken out when they are whitened: `(1 − 1/√(1 + ρ²|d|²)) / |d|²`, of ρ = `shared` and
/// |d|² = `squares`, the sum of 1/σ² over the rows; zero of no rows.
pub fn shrinkage(shared: f64, squares: f64) -> f64 {
    if squares > 0.0 { (1.0 - 1.0 / (1.0 + shared * shared * squares).sqrt()) / squares } else { 0.0 }
}

/// Whitens one axis of one visit, in place: `rows` are the block's rows (each `width` numbers of `block`) whose
/// deviations are `sd`.
pub(crate) fn whiten(
    block: &mut [f64],
    width: usize,
    rows: &[usize],
    sd: &[f64],
    visit_sd: f64,
    dot: &mut [f64],
) {
    for (&row, &sigma) in rows.iter().zip(sd) {
        block[row * width..(row + 1) * width].iter_mut().for_each(|v| *v /= sigma);
    }
    if rows.len() < 2 && visit_sd <= 0.0 {
        return;
    }
    let squares: f64 = sd.iter().map(|sigma| 1.0 / (sigma * sigma)).sum();
    let shrink = shrinkage(visit_sd, squares);
    if shrink <= 0.0 {
        return;
    }
    dot.fill(0.0);
    for (&row, &sigma) in rows.iter().zip(sd) {
        for (d, v) in dot.iter_mut().zip(&block[row * width..(row + 1) * width]) {
            *d += v / sigma;
        }
    }
    for (&row, &sigma) in rows.iter().zip(sd) {
        for (v, d) in block[row * width..(row + 1) * width].iter_mut().zip(dot.iter()) {
            *v -= shrink * d / sigma;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn whitening_undoes_the_covariance() {
        let (sd, rho) = ([1e-4, 2e-4, 5e-5], 3e-4);
        let covariance = DMatrix::from_fn(3, 3, |i, j| rho * rho + if i == j { sd[i] * sd[i] } else { 0.0 });
        // Columns of the whitening W, by whitening unit rows: W V Wᵀ = I.
        let mut block = DMatrix::<f64>::identity(3, 3).transpose().as_slice().to_vec();
        whiten(&mut block, 3, &[0, 1, 2], &sd, rho, &mut [0.0; 3]);
        let w = DMatrix::from_row_slice(3, 3, &block);
        let unit = &w * covariance * w.transpose();
        assert!((unit - DMatrix::identity(3, 3)).amax() < 1e-12);
        let one = DVector::from_element(3, 1.0);
        assert!((w * one).norm() < 1.0 / rho, "what a visit shares weighs no more than one look at it");
    }
}
