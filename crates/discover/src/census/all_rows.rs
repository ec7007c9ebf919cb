//! The coefficients of all rows.

use crate::census::blocks::Blocks;
use crate::census::derived::Derived;
use crate::census::white::White;
use crate::error::DiscoverError;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::problem::whitening::Whitener;
use crate::statistics::product::gram_matrix;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::Dataset;
use truepose_identify::Fit;

/// A fit with the coefficients of all rows.
pub(crate) struct AllRows {
    /// Its coefficients and their covariance are those of all rows; structure, noise and prior are those of the fit that it began with.
    pub fit: Fit,
    /// That of the step before, at which all rows are linearised: A, and what it takes of a candidate, belong together.
    pub at: Fit,
    /// (Σ AᵀA + WᵀW)⁻¹, r × r, whitened.
    pub inverse: DMatrix<f64>,
    /// Σ ‖r‖², whitened, of its coefficients.
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

impl Equations {
    fn add(&mut self, other: &Equations) {
        self.gram += &other.gram;
        self.right += &other.right;
        self.squares += other.squares;
        self.count += other.count;
    }
}

/// The coefficients of a fit that the data determines.
fn kept(fit: &Fit) -> DVector<f64> {
    let kept = &fit.reduction.kept;
    DVector::from_iterator(kept.len(), kept.iter().map(|&k| fit.fitted.coefficients()[k]))
}

impl AllRows {
    /// What these coefficients leave of a block that is linearised where they were found, whitened.
    pub fn residual_of(&self, linearisation: &Linearisation<'_>, whitener: &Whitener) -> DVector<f64> {
        let residual = &linearisation.y - &linearisation.base * kept(&self.fit);
        let mut column = DMatrix::from_column_slice(residual.len(), 1, residual.as_slice());
        whitener.apply(&mut column);
        column.column(0).into_owned()
    }

    /// Gauss–Newton from a fit of some of the rows. Its coefficients are near those of all, so that one step does; what it leaves is computed from a
    /// part of the blocks:
    ///
    /// ```text
    /// d = Σ_part Aᵀr (c + Δ) − (Σ_part Aᵀr (c) − Σ_part AᵀA Δ)        what is not linear
    /// ```
    ///
    /// A further step is made where the share of all blocks, d B/b, would win something.
    pub fn of(fit: &Fit, blocks: &Blocks, options: &DiscoverOptions) -> Result<Self, DiscoverError> {
        const STEPS: usize = 3;
        /// Decrease of the sum of squares, whitened, that is none: no coefficient moves by more than a hundredth of its standard deviation.
        const STILL: f64 = 1e-4;
        let mut fit = fit.clone();
        let derived = blocks.derived(&fit, std::iter::empty());
        let part = blocks.part();
        let mut step = 0;
        loop {
            let [whole, before] = equations(&fit, (blocks, &derived), [1, part], options)?;
            let Equations { mut gram, mut right, squares, count } = whole;
            let kept = fit.reduction.kept.clone();
            let own = self::kept(&fit);
            if let Some(prior) = fit.prior.rows() {
                let held = gram_matrix(&prior);
                right -= &held * &own;
                gram += held;
            }
            let Some(inverse) = inverse(&gram) else {
                let inverse = DMatrix::zeros(kept.len(), kept.len());
                return Ok(AllRows { at: fit.clone(), fit, inverse, squares, count });
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
            let at = fit.clone();
            fit.fitted = fit.fitted.with_coefficients(coefficients, covariance)?;
            fit.observations = count;
            fit.chi_square = squares - gained;
            step += 1;
            if gained >= STILL && step < STEPS {
                let [after, _] = equations(&fit, (blocks, &derived), [part, part], options)?;
                let left = (after.right - (before.right - before.gram * &change)) * blocks.times(part);
                if left.dot(&(&inverse * &left)) >= STILL {
                    continue;
                }
            }
            return Ok(AllRows { squares: fit.chi_square, fit, at, inverse, count });
        }
    }
}

/// Sums over the blocks of two strides, of which the second is a multiple of the first.
fn equations(
    fit: &Fit,
    (blocks, derived): (&Blocks, &Derived),
    [every, rarer]: [usize; 2],
    options: &DiscoverOptions,
) -> Result<[Equations; 2], DiscoverError> {
    let r = fit.reduction.kept.len();
    let nothing =
        || Equations { gram: DMatrix::zeros(r, r), right: DVector::zeros(r), squares: 0.0, count: 0 };
    let (mut sum, mut some) = (nothing(), nothing());
    let of = |block: &Dataset| -> Result<Equations, DiscoverError> {
        let White { base, residual, .. } = White::of((block, blocks), (fit, fit), &[], options)?;
        Ok(Equations {
            gram: gram_matrix(&base),
            right: base.tr_mul(&residual),
            squares: residual.norm_squared(),
            count: residual.len(),
        })
    };
    blocks.each(every, derived, &of, &mut |block, part| {
        sum.add(&part);
        if block % rarer == 0 {
            some.add(&part);
        }
    })?;
    Ok([sum, some])
}

/// The inverse of a positive definite matrix whose rows are in different units.
fn inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let size: Vec<f64> = matrix.diagonal().iter().map(|v| v.sqrt()).collect();
    let scaled = DMatrix::from_fn(size.len(), size.len(), |i, j| matrix[(i, j)] / (size[i] * size[j]));
    let solved = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(size.len(), size.len(), |i, j| solved[(i, j)] / (size[i] * size[j])))
}
