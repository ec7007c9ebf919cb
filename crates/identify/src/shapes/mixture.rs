//! What coefficients owe to a shape parameter whose squares are no parabola: all of its values, each as likely as its squares say.
//!
//! ```text
//! w_g ∝ l_g exp(−(S_g − S)/2)        Δ cov c = Σ w_g (Z_g V_g Z_gᵀ + δ_g δ_gᵀ) − Z V Zᵀ,   δ_g = Z_g b_g − Z b
//! V_g = (X̃_gᵀ X̃_g)⁻¹       Z_g = [1; −(Qᵀ A)⁻¹ Qᵀ X_g]       b_g = X̃_g⁺ ỹ
//! ```
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | l_g | length of the piece of the parameter's range that this value stands for | 1 |
//! | S_g | whitened squares with this value | 1 |
//! | b_g | coefficients of the effects with this value | k |
//! | Z_g | how all coefficients go with them | (r + k) × k |
//!
//! Without a subscript: at the value that was found. A step that may have come between any of five visits is larger for one of them than for
//! another, and the one that fits best is mostly the one that makes it largest: at that instant held fast its interval would be too
//! narrow. The mean over the values and their weights is that of Laplace, piece by piece (Tierney and Kadane 1986; MacKay 1992).

use super::grid::Range;
use super::picture::Picture;
use super::refine::solved;
use crate::IdentifyError;
use nalgebra::{DMatrix, DVector};

/// All coefficients with one value of the parameter: the others above, the effects' own below.
struct At {
    squares: f64,
    /// Z b.
    coefficients: DVector<f64>,
    /// Z V Zᵀ.
    covariance: DMatrix<f64>,
}

impl At {
    fn of(picture: &Picture<'_>, theta: &[f64]) -> Result<Option<Self>, IdentifyError> {
        let columns = picture.all(theta)?;
        let beyond = picture.beyond(columns.clone());
        let Some(own) = beyond.tr_mul(&beyond).try_inverse() else { return Ok(None) };
        let (b, squares) = solved(&beyond, &picture.target)?;
        let Some(others) = picture.triangle.solve_upper_triangular(&picture.along(&columns)) else {
            return Ok(None);
        };
        let (r, k) = others.shape();
        let mut z = DMatrix::identity(r + k, k);
        z.rows_mut(0, r).copy_from(&(-others));
        z.rows_mut(r, k).fill_with_identity();
        Ok(Some(At { squares, coefficients: &z * b, covariance: &z * own * z.transpose() }))
    }
}

/// What the covariance of (others, own) grows by when a parameter may have each of these values: the middle of each piece, by its length.
pub(super) fn more(
    picture: &Picture<'_>,
    theta: &[f64],
    k: usize,
    pieces: &[Range],
) -> Result<Option<DMatrix<f64>>, IdentifyError> {
    let Some(here) = At::of(picture, theta)? else { return Ok(None) };
    let share = picture.share();
    let size = here.coefficients.len();
    let (mut sum, mut weights) = (DMatrix::zeros(size, size), 0.0);
    for piece in pieces {
        let mut trial = theta.to_vec();
        trial[k] = 0.5 * (piece[0] + piece[1]);
        let Some(there) = At::of(picture, &trial)? else { continue };
        let weight = (piece[1] - piece[0]) * (-0.5 * (there.squares - here.squares) / share).exp();
        let apart = &there.coefficients - &here.coefficients;
        sum += (there.covariance * share + &apart * apart.transpose()) * weight;
        weights += weight;
    }
    Ok((weights > 0.0).then(|| sum / weights - here.covariance * share))
}
