//! How well shape parameters are known, and what they cost the coefficients.
//!
//! ```text
//! D_k = (∂X/∂θ_k) b        D̃ = D − A Z, Z = A⁺ D        cov θ = (D̃ᵀ D̃)⁻¹        cov c = (AᵀA)⁻¹ + Z cov θ Zᵀ
//! ```
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | A | all kept columns at the solution, with the rows of the prior | m × r |
//! | b | coefficients of the effects' columns | k |
//!
//! An instant has no slope. Its interval holds every gap between visits at which the whitened squares are less than 3.84 (95 %
//! of χ² with one degree of freedom) above the least.

use super::FittedShape;
use super::grid::gaps;
use super::picture::Picture;
use super::refine::{Valley, left};
use crate::{Fit, IdentifyError, student_quantile};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use truepose_errormodel::{FittedModel, Search, Shape};

/// 95 % of χ² with one degree of freedom.
const CHI_SQUARE: f64 = 3.841_458_820_694_124;

/// Z over (other columns, the effects' columns) and the covariance of the smooth parameters.
struct Known {
    smooth: Vec<usize>,
    covariance: DMatrix<f64>,
    others: DMatrix<f64>,
    own: DMatrix<f64>,
}

impl Known {
    fn of(picture: &Picture<'_>, shapes: &[Shape], theta: &[f64]) -> Result<Self, IdentifyError> {
        let every: Vec<usize> = (0..shapes.len()).collect();
        let valley = Valley::new(picture, shapes, theta, &every)?;
        let smooth = valley.smooth.clone();
        let moved: Vec<f64> = smooth.iter().map(|&k| theta[k]).collect();
        let slopes: Vec<DVector<f64>> = (0..smooth.len())
            .into_par_iter()
            .map(|k| valley.slope(&moved, k, &picture.coefficients))
            .collect::<Result<_, _>>()?;
        let slopes = match slopes.is_empty() {
            true => DMatrix::zeros(picture.target.len(), 0),
            false => DMatrix::from_columns(&slopes),
        };
        let columns = picture.all(theta)?;
        let (x, d) = (picture.beyond(columns.clone()), picture.beyond(slopes.clone()));
        // Z of the effects' columns by least squares on what is beyond the others, then of the others by their triangle.
        let own = least_squares(&x, &d)?;
        let rest = &d - &x * &own;
        let others = picture
            .triangle
            .solve_upper_triangular(&(picture.along(&slopes) - picture.along(&columns) * &own))
            .unwrap_or_else(|| DMatrix::zeros(picture.triangle.ncols(), smooth.len()));
        let gram = rest.tr_mul(&rest);
        let covariance = gram
            .try_inverse()
            .unwrap_or_else(|| DMatrix::from_diagonal_element(smooth.len(), smooth.len(), f64::MAX.sqrt()));
        Ok(Known { smooth, covariance, others, own })
    }
}

/// Columns of `b` in least squares by columns of `a`.
fn least_squares(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<DMatrix<f64>, IdentifyError> {
    use truepose_solvers::{LeastSquares, PivotedQr, Solver};
    let mut x = DMatrix::zeros(a.ncols(), b.ncols());
    for k in 0..b.ncols() {
        let y: DVector<f64> = b.column(k).into_owned();
        x.set_column(k, &PivotedQr::default().solve(&LeastSquares::new(a, &y))?.x);
    }
    Ok(x)
}

/// Standard deviation of each parameter; of an instant the gap in which it lies.
pub(super) fn deviations(
    picture: &Picture<'_>,
    shapes: &[Shape],
    theta: &[f64],
) -> Result<Vec<f64>, IdentifyError> {
    let known = Known::of(picture, shapes, theta)?;
    let mut all: Vec<f64> = shapes.iter().map(|s| 1e-9 * (s.upper - s.lower)).collect();
    for (place, &k) in known.smooth.iter().enumerate() {
        all[k] = known.covariance[(place, place)].sqrt().max(1e-14 * theta[k].abs()).max(f64::MIN_POSITIVE);
    }
    Ok(all)
}

/// Writes intervals into a fit, and what the parameters' uncertainty adds to the covariance.
pub(super) fn judge(
    picture: &Picture<'_>,
    free: &[(usize, Shape)],
    theta: &[f64],
    fit: &mut Fit,
) -> Result<(), IdentifyError> {
    let shapes: Vec<Shape> = free.iter().map(|(_, shape)| shape.clone()).collect();
    let mut known = Known::of(picture, &shapes, theta)?;
    // What a part of the visits says, the whole says the better the more there are.
    known.covariance *= picture.share();
    let freedom = fit.degrees_of_freedom().saturating_sub(shapes.len()).max(1);
    let quantile = student_quantile(0.975, freedom);
    for (k, (effect, shape)) in free.iter().enumerate() {
        let interval = match known.smooth.iter().position(|&s| s == k) {
            Some(place) => {
                let half = quantile * known.covariance[(place, place)].sqrt();
                // Of an effect that explains nothing, or was left out, the data says nothing: the whole range.
                let nothing = half.is_nan() || half > shape.upper - shape.lower;
                if nothing { [shape.lower, shape.upper] } else { [theta[k] - half, theta[k] + half] }
            }
            None => instant(picture, shape, theta, k)?,
        };
        fit.shapes.push(FittedShape {
            effect: *effect,
            name: shape.name.clone(),
            unit: match shape.search {
                Search::Period(joint, _) => picture.chain().joint(joint).unit().into(),
                _ => shape.unit.clone(),
            },
            value: theta[k],
            interval,
            range: [shape.lower, shape.upper],
        });
    }
    let mut z = DMatrix::zeros(fit.reduction.rank(), known.smooth.len());
    for (rows, places) in [(&known.others, &picture.places.0), (&known.own, &picture.places.1)] {
        places.iter().enumerate().for_each(|(k, &place)| z.set_row(place, &rows.row(k)));
    }
    let more = &z * &known.covariance * z.transpose();
    let mut covariance = fit.fitted.covariance().clone();
    for (i, &a) in fit.reduction.kept.iter().enumerate() {
        for (j, &b) in fit.reduction.kept.iter().enumerate() {
            covariance[(a, b)] += more[(i, j)];
        }
    }
    let old = &fit.fitted;
    let mut fitted = FittedModel::new(old.model().clone(), old.coefficients().to_vec(), covariance)?;
    fitted.channels.clone_from(&old.channels);
    fitted.domain = old.domain.clone();
    fitted.noise = old.noise;
    fitted.provenance = old.provenance.clone();
    fit.fitted = fitted;
    Ok(())
}

/// Every gap that is nearly as good as the best, walking outwards from it until a gap is not.
fn instant(picture: &Picture<'_>, shape: &Shape, theta: &[f64], k: usize) -> Result<[f64; 2], IdentifyError> {
    debug_assert_eq!(shape.search, Search::Instant);
    let gaps = gaps(shape, picture.data);
    let here = gaps.iter().position(|gap| gap[0] <= theta[k] && theta[k] <= gap[1]);
    let Some(here) = here else { return Ok([theta[k]; 2]) };
    let height = |gap: &[f64; 2]| -> Result<f64, IdentifyError> {
        let mut trial = theta.to_vec();
        trial[k] = 0.5 * (gap[0] + gap[1]);
        left(&picture.beyond(picture.all(&trial)?), &picture.target)
    };
    let least = height(&gaps[here])?;
    let mut ends = gaps[here];
    for gap in gaps[..here].iter().rev() {
        if height(gap)? > least + CHI_SQUARE {
            break;
        }
        ends[0] = gap[0];
    }
    for gap in &gaps[here + 1..] {
        if height(gap)? > least + CHI_SQUARE {
            break;
        }
        ends[1] = gap[1];
    }
    Ok(ends)
}
