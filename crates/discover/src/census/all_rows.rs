//! The coefficients of all rows.

use crate::census::blocks::Blocks;
use crate::error::DiscoverError;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::statistics::product::gram_matrix;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::Dataset;
use truepose_identify::Fit;

/// A fit with the coefficients of all rows.
pub(crate) struct AllRows {
    /// Its coefficients and their covariance are those of all rows; structure, noise and prior are those of the fit that it began with.
    pub fit: Fit,
    /// (Σ AᵀA + WᵀW)⁻¹, r × r, whitened.
    pub inverse: DMatrix<f64>,
    /// Σ ‖r‖², whitened, at the step before the last.
    pub squares: f64,
    /// How many numbers were measured.
    pub count: usize,
}

/// Σ AᵀA, Σ Aᵀr, Σ ‖r‖² and the number of numbers.
struct Equations {
    gram: DMatrix<f64>,
    right: DVector<f64>,
    squares: f64,
    count: usize,
}

/// Whitened base and residual of a block.
pub(crate) fn whitened(linearisation: &Linearisation<'_>) -> (DMatrix<f64>, DVector<f64>) {
    let whitener = linearisation.whitener(linearisation.noise);
    let residual = &linearisation.y - &linearisation.base * linearisation.coefficients();
    let mut column = DMatrix::from_column_slice(residual.len(), 1, residual.as_slice());
    whitener.apply(&mut column);
    (whitener.of(&linearisation.base), column.column(0).into_owned())
}

impl AllRows {
    /// Gauss–Newton from a fit of some of the rows: its coefficients are near those of all, so that two steps are more than enough.
    pub fn of(fit: &Fit, blocks: &Blocks, options: &DiscoverOptions) -> Result<Self, DiscoverError> {
        const STEPS: usize = 3;
        /// Decrease of the sum of squares, whitened, that is none.
        const STILL: f64 = 1e-3;
        let mut fit = fit.clone();
        let mut step = 0;
        loop {
            let Equations { gram, right, squares, count } = equations(&fit, blocks, options)?;
            let kept = fit.reduction.kept.clone();
            let own = DVector::from_iterator(kept.len(), kept.iter().map(|&k| fit.fitted.coefficients()[k]));
            let (mut gram, mut right) = (gram, right);
            if let Some(prior) = fit.prior.rows() {
                let held = gram_matrix(&prior);
                right -= &held * &own;
                gram += held;
            }
            let Some(inverse) = inverse(&gram) else {
                return Ok(AllRows { fit, inverse: DMatrix::zeros(kept.len(), kept.len()), squares, count });
            };
            let change = &inverse * &right;
            let gained = change.dot(&right);
            let mut coefficients = fit.fitted.coefficients().to_vec();
            kept.iter().zip(change.iter()).for_each(|(&k, change)| coefficients[k] += change);
            let mut covariance = DMatrix::zeros(coefficients.len(), coefficients.len());
            for (i, &a) in kept.iter().enumerate() {
                for (j, &b) in kept.iter().enumerate() {
                    covariance[(a, b)] = inverse[(i, j)];
                }
            }
            fit.fitted = fit.fitted.with_coefficients(coefficients, covariance)?;
            fit.observations = count;
            fit.chi_square = squares - gained;
            step += 1;
            if gained < STILL || step == STEPS {
                return Ok(AllRows { fit, inverse, squares, count });
            }
        }
    }
}

fn equations(fit: &Fit, blocks: &Blocks, options: &DiscoverOptions) -> Result<Equations, DiscoverError> {
    let r = fit.reduction.kept.len();
    let mut sum = Equations { gram: DMatrix::zeros(r, r), right: DVector::zeros(r), squares: 0.0, count: 0 };
    let of = |block: &Dataset| -> Result<Equations, DiscoverError> {
        let linearisation = blocks.linearised(fit, block, options)?;
        let (base, residual) = whitened(&linearisation);
        Ok(Equations {
            gram: gram_matrix(&base),
            right: base.tr_mul(&residual),
            squares: residual.norm_squared(),
            count: residual.len(),
        })
    };
    blocks.each(1, &of, &mut |_, part| {
        sum.gram += part.gram;
        sum.right += part.right;
        sum.squares += part.squares;
        sum.count += part.count;
    })?;
    Ok(sum)
}

/// The inverse of a positive definite matrix whose rows are in different units.
fn inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let size: Vec<f64> = matrix.diagonal().iter().map(|v| v.sqrt()).collect();
    let scaled = DMatrix::from_fn(size.len(), size.len(), |i, j| matrix[(i, j)] / (size[i] * size[j]));
    let solved = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(size.len(), size.len(), |i, j| solved[(i, j)] / (size[i] * size[j])))
}
