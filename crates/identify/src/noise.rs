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
//!
//! Rows that measured numbers along directions w_i share the displacement of the robot in space: `V = diag(s² + τ²) + ρ² U Uᵀ`, the rows of U
//! being w_iᵀ. With the eigenvectors e_k and eigenvalues λ_k of `Σ d_i² w_i w_iᵀ`, v_k = (d_i w_i·e_k)_i are orthogonal, |v_k|² = λ_k, and
//! the same formula is applied along each of them.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use truepose_errormodel::Dataset;

/// By how much what the rows of a visit share is taken out when they are whitened: `(1 − 1/√(1 + ρ²|d|²)) / |d|²`, of ρ = `shared` and
/// |d|² = `squares`, the sum of 1/σ² over the rows; zero of no rows.
pub fn shrinkage(shared: f64, squares: f64) -> f64 {
    if squares > 0.0 { (1.0 - 1.0 / (1.0 + shared * shared * squares).sqrt()) / squares } else { 0.0 }
}

/// The directions v in which whitened numbers of one visit and component share what displaces the robot, orthogonal, one number a row: d itself
/// for numbers along an axis of the measurement frame; up to three for numbers along directions `rays` of their own (w, one a row).
pub fn directions(weights: &[f64], rays: &[Vector3<f64>]) -> Vec<Vec<f64>> {
    if rays.is_empty() {
        return vec![weights.to_vec()];
    }
    let pairs = || weights.iter().zip(rays);
    spanned(&pairs().map(|(d, w)| d * d * w * w.transpose()).sum::<Matrix3<f64>>())
        .into_iter()
        .map(|(axis, _)| pairs().map(|(d, w)| d * w.dot(&axis)).collect())
        .collect()
}

/// Eigenvectors and eigenvalues of `Σ d² w wᵀ` that are not rounding.
pub(crate) fn spanned(squares: &Matrix3<f64>) -> Vec<(Vector3<f64>, f64)> {
    /// Of the largest eigenvalue.
    const ROUNDING: f64 = 1e-9;
    let eigen = SymmetricEigen::new(*squares);
    let least = ROUNDING * eigen.eigenvalues.amax();
    (0..3)
        .filter(|&k| eigen.eigenvalues[k] > least)
        .map(|k| (eigen.eigenvectors.column(k).into_owned(), eigen.eigenvalues[k]))
        .collect()
}

/// The directions w of rows that measured numbers along directions of their own; none where they measured along axes.
pub fn rays_of(data: &Dataset, component: usize, rows: impl Iterator<Item = usize>) -> Vec<Vector3<f64>> {
    if component != 0 || data.rays().is_none() {
        return Vec::new();
    }
    rows.map(|row| data.ray(row)).collect::<Option<Vec<_>>>().unwrap_or_default()
}

/// A number of a standstill: what is left of it, 1/σ², the direction w along which it was measured, and whether it counts for the others.
pub type Beside = (f64, f64, Vector3<f64>, bool);

/// Each number of a standstill over the standard deviation that the others leave it, N(0, 1) under the noise model:
///
/// ```text
/// e_i = (r_i − w_i·ê)/√(σ_i² + w_iᵀ P⁻¹ w_i),   P = 1/ρ² + Σ w_j w_jᵀ/σ_j²,   ê = P⁻¹ Σ w_j r_j/σ_j²,   j ≠ i, those that count
/// ```
pub fn beside_others(numbers: &[Beside], shared: f64) -> Vec<f64> {
    let prior = Matrix3::from_diagonal_element(1.0 / (shared * shared).max(1e-30));
    let counted = |number: &Beside| if number.3 { number.1 } else { 0.0 };
    let (whole, along) = numbers.iter().fold((prior, Vector3::zeros()), |(whole, along), number| {
        let (r, w) = (number.0, number.2);
        (whole + w * w.transpose() * counted(number), along + w * (counted(number) * r))
    });
    let each = |number: &Beside| {
        let (r, precision, w, _) = *number;
        let own = counted(number);
        let covariance = (whole - w * w.transpose() * own).try_inverse().unwrap_or_default();
        let expected = w.dot(&(covariance * (along - w * (own * r))));
        (r - expected) / (1.0 / precision + w.dot(&(covariance * w))).sqrt()
    };
    numbers.iter().map(each).collect()
}

/// Whitens one axis of one visit, in place: `rows` are the block's rows (each `width` numbers of `block`) whose
/// deviations are `sd`, and whose directions are `rays` where they have any.
pub(crate) fn whiten(
    (block, width): (&mut [f64], usize),
    rows: &[usize],
    sd: &[f64],
    rays: &[Vector3<f64>],
    visit_sd: f64,
    dot: &mut [f64],
) {
    for (&row, &sigma) in rows.iter().zip(sd) {
        block[row * width..(row + 1) * width].iter_mut().for_each(|v| *v /= sigma);
    }
    if visit_sd <= 0.0 {
        return;
    }
    let weights: Vec<f64> = sd.iter().map(|sigma| 1.0 / sigma).collect();
    for along in directions(&weights, rays) {
        let shrink = shrinkage(visit_sd, along.iter().map(|v| v * v).sum());
        dot.fill(0.0);
        for (&row, along) in rows.iter().zip(&along) {
            for (d, v) in dot.iter_mut().zip(&block[row * width..(row + 1) * width]) {
                *d += along * v;
            }
        }
        for (&row, along) in rows.iter().zip(&along) {
            for (v, d) in block[row * width..(row + 1) * width].iter_mut().zip(dot.iter()) {
                *v -= shrink * d * along;
            }
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
        whiten((&mut block, 3), &[0, 1, 2], &sd, &[], rho, &mut [0.0; 3]);
        let w = DMatrix::from_row_slice(3, 3, &block);
        let unit = &w * covariance * w.transpose();
        assert!((unit - DMatrix::identity(3, 3)).amax() < 1e-12);
        let one = DVector::from_element(3, 1.0);
        assert!((w * one).norm() < 1.0 / rho, "what a visit shares weighs no more than one look at it");
    }

    #[test]
    fn numbers_along_directions_share_the_displacement_in_space() {
        let (sd, rho) = ([1e-4, 2e-4, 5e-5, 1e-4, 3e-4], 3e-4);
        let w = [[1.0, 0.2, 0.1], [0.0, 2.0, 0.3], [0.5, 0.5, -1.0], [0.9, -0.1, 0.0], [0.1, 0.0, 1.5]]
            .map(Vector3::from);
        let covariance = DMatrix::from_fn(5, 5, |i, j| {
            rho * rho * w[i].dot(&w[j]) + if i == j { sd[i] * sd[i] } else { 0.0 }
        });
        let mut block = DMatrix::<f64>::identity(5, 5).as_slice().to_vec();
        whiten((&mut block, 5), &[0, 1, 2, 3, 4], &sd, &w, rho, &mut [0.0; 5]);
        let white = DMatrix::from_row_slice(5, 5, &block);
        let unit = &white * covariance * white.transpose();
        assert!((unit - DMatrix::identity(5, 5)).amax() < 1e-12);
        // Two numbers span two directions alone.
        assert_eq!(directions(&[1.0, 1.0], &w[..2]).len(), 2);
        assert_eq!(directions(&[1.0, 1.0], &[w[0], w[0]]).len(), 1);
    }
}
