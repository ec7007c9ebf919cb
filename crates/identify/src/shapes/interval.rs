//! How well shape parameters are known, and what they cost the coefficients.
//!
//! ```text
//! D_k = (∂X/∂θ_k) b        D̃ = D − A Z, Z = A⁺ D        cov θ = (D̃ᵀ D̃)⁻¹        cov c = (AᵀA)⁻¹ + Z cov θ Zᵀ
//! ```
//!
//! The second part of cov c widens the intervals of the coefficients ([`Fit::half_widths`]) and is no part of the covariance of the fit: where
//! the robot was measured, an error of θ and what it does to c cancel in a prediction, whose band would be many times too wide with one
//! of the two alone.
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | A | all kept columns at the solution, with the rows of the prior | m × r |
//! | b | coefficients of the effects' columns | k |
//!
//! The interval of a smooth parameter goes to where the whitened squares, with the coefficients solved for anew, are t² above the
//! least (t: Student's quantile): a load on a flank or a time constant that is hardly known is known unevenly, farther up than down. Of an effect that
//! is hardly seen it holds every valley that is as deep. Beside
//! other parameters that are free it is as much longer as they let it be: by √((cov θ)_kk |D̃_k|²). Of many (the periods of all gears
//! of an arm) it is t standard deviations to either side: following each would take minutes.
//!
//! An instant has no slope, and the likelihood ratio of an instant follows no χ²: left and right of the truth the squares walk at
//! random, and with P(ratio ≤ c) = (1 − e^{−c/2})² it takes c = 7.35 for 95 %. Its interval holds every gap between visits at which the
//! whitened squares are less than that above the least (Hansen 2000, table I).

use super::grid::{Range, gaps, values};
use super::late::{self, Gains, Moved};
use super::mixture;
use super::picture::Picture;
use super::refine::{Valley, left};
use crate::IdentifyError;
use crate::fit::{Fit, FittedNonlinear};
use crate::student::student_quantile;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use truepose_errormodel::{NonlinearParameter, Search};

/// −2 ln(1 − √0.95): 95 % of the likelihood ratio of an instant.
const RATIO: f64 = 7.352_217_9;

/// An effect that takes less than this off the whitened squares may be found in a wrong valley.
const WEAK: f64 = 100.0;

/// With more free parameters than this the squares are not followed.
const MANY: usize = 8;

/// Farther above than this beyond it no gap comes back.
const FAR: f64 = 10.0;

/// Z over (other columns, the effects' columns) and the covariance of the smooth parameters.
struct Known {
    smooth: Vec<usize>,
    covariance: DMatrix<f64>,
    /// Variances if the other parameters were known.
    alone: Vec<f64>,
    others: DMatrix<f64>,
    own: DMatrix<f64>,
    /// X̃ and D̃ less what X̃ has of it.
    columns: DMatrix<f64>,
    slopes: DMatrix<f64>,
}

impl Known {
    fn of(
        picture: &Picture<'_>,
        shapes: &[NonlinearParameter],
        theta: &[f64],
    ) -> Result<Self, IdentifyError> {
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
        let alone = gram.diagonal().iter().map(|square| 1.0 / square).collect();
        let covariance = gram
            .try_inverse()
            .unwrap_or_else(|| DMatrix::from_diagonal_element(smooth.len(), smooth.len(), f64::MAX.sqrt()));
        Ok(Known { smooth, covariance, alone, others, own, columns: x, slopes: rest })
    }

    /// What the noise of channels moves that effects follow late.
    fn moved(&self, picture: &Picture<'_>, theta: &[f64]) -> Result<Vec<Moved>, IdentifyError> {
        let Some(gram) = self.columns.tr_mul(&self.columns).try_inverse() else { return Ok(Vec::new()) };
        let shapes = &self.covariance * self.slopes.transpose();
        let alone = gram * self.columns.transpose();
        let basis = picture.basis().transpose();
        let along = picture.along(&picture.all(theta)?);
        let others = match picture.triangle.solve_upper_triangular(&(basis - along * &alone)) {
            Some(others) => others - &self.others * &shapes,
            None => return Ok(Vec::new()),
        };
        let own = alone - &self.own * &shapes;
        late::moved(picture, theta, &Gains { shapes: &shapes, others: &others, own: &own })
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
    shapes: &[NonlinearParameter],
    theta: &[f64],
) -> Result<Vec<f64>, IdentifyError> {
    let known = Known::of(picture, shapes, theta)?;
    let mut all: Vec<f64> = shapes.iter().map(|s| 1e-9 * (s.upper - s.lower)).collect();
    for (place, &k) in known.smooth.iter().enumerate() {
        all[k] = known.covariance[(place, place)].sqrt().max(1e-14 * theta[k].abs()).max(f64::MIN_POSITIVE);
    }
    Ok(all)
}

/// Writes intervals into a fit, and what the parameters' uncertainty adds to the variances of the coefficients.
pub(super) fn judge(
    picture: &Picture<'_>,
    free: &[(usize, NonlinearParameter)],
    theta: &[f64],
    fit: &mut Fit,
) -> Result<(), IdentifyError> {
    let shapes: Vec<NonlinearParameter> = free.iter().map(|(_, shape)| shape.clone()).collect();
    let mut known = Known::of(picture, &shapes, theta)?;
    let moved = known.moved(picture, theta)?;
    // What a part of the visits says, the whole says the better the more there are.
    known.covariance *= picture.share();
    let freedom = fit.degrees_of_freedom().saturating_sub(shapes.len()).max(1);
    let quantile = student_quantile(0.975, freedom);
    let one = shapes.len() == 1;
    let mut pieces: Vec<(usize, Vec<Range>)> = Vec::new();
    for (k, (effect, shape)) in free.iter().enumerate() {
        let interval = match known.smooth.iter().position(|&s| s == k) {
            Some(place) => {
                let alone = known.alone[place] * picture.share();
                let half = quantile * alone.sqrt();
                let noise: f64 = moved.iter().map(|moved| moved.shapes.row(place).norm_squared()).sum();
                let stretch = ((known.covariance[(place, place)] + noise) / alone).sqrt();
                // Of an effect that explains nothing, or was left out, the data says nothing: the whole range.
                if !half.is_finite() || stretch.is_nan() {
                    [shape.lower, shape.upper]
                } else if shapes.len() > MANY {
                    [-half, half].map(|way| (theta[k] + stretch * way).clamp(shape.lower, shape.upper))
                } else {
                    let allowed = quantile * quantile * picture.share();
                    profile(picture, shape, theta, k, (half, allowed))?
                        .map(|end| (theta[k] + stretch * (end - theta[k])).clamp(shape.lower, shape.upper))
                }
            }
            None => {
                let (interval, all) = instant(picture, shape, theta, k)?;
                pieces.push((k, all));
                interval
            }
        };
        if one && shape.search == Search::Smooth && interval[0] < interval[1] {
            pieces.push((k, around(interval, theta[k], shape)));
        }
        fit.shapes.push(FittedNonlinear {
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
    let mut more = &z * &known.covariance * z.transpose();
    for (k, pieces) in &pieces {
        let places: Vec<usize> = picture.places.0.iter().chain(&picture.places.1).copied().collect();
        let Some(mixed) = mixture::more(picture, theta, *k, pieces)? else { continue };
        // Of a smooth parameter the parabola was but a first guess.
        if shapes[*k].search == Search::Smooth {
            more.fill(0.0);
        }
        for (i, &a) in places.iter().enumerate() {
            for (j, &b) in places.iter().enumerate() {
                more[(a, b)] += mixed[(i, j)];
            }
        }
    }
    for moved in moved {
        let mut late = DMatrix::zeros(fit.reduction.rank(), moved.own.ncols());
        for (rows, places) in [(&moved.others, &picture.places.0), (&moved.own, &picture.places.1)] {
            places.iter().enumerate().for_each(|(k, &place)| late.set_row(place, &rows.row(k)));
        }
        more += &late * late.transpose();
    }
    fit.unknown_shapes = vec![0.0; fit.fitted.coefficients().len()];
    for (i, &column) in fit.reduction.kept.iter().enumerate() {
        fit.unknown_shapes[column] = more[(i, i)].max(0.0);
    }
    Ok(())
}

/// From the first gap that is nearly as good as the best to the last, walking outwards from it until gaps are far worse; and those that are not.
fn instant(
    picture: &Picture<'_>,
    shape: &NonlinearParameter,
    theta: &[f64],
    k: usize,
) -> Result<(Range, Vec<Range>), IdentifyError> {
    debug_assert_eq!(shape.search, Search::Instant);
    let gaps = gaps(shape, picture.data);
    let here = gaps.iter().position(|gap| gap[0] <= theta[k] && theta[k] <= gap[1]);
    let Some(here) = here else { return Ok(([theta[k]; 2], Vec::new())) };
    let middle = |gap: &Range| height(picture, theta, k, 0.5 * (gap[0] + gap[1]));
    let least = middle(&gaps[here])?;
    let (mut ends, mut near) = (gaps[here], vec![gaps[here]]);
    let (before, after) = (&gaps[..here], &gaps[here + 1..]);
    let outwards: [&mut dyn Iterator<Item = &Range>; 2] = [&mut before.iter().rev(), &mut after.iter()];
    for gaps in outwards {
        for gap in gaps {
            let above = middle(gap)? - least;
            if above > RATIO + FAR {
                break;
            }
            near.push(*gap);
            if above <= RATIO {
                ends = [ends[0].min(gap[0]), ends[1].max(gap[1])];
            }
        }
    }
    Ok((ends, near))
}

/// Pieces of a parameter's range on both sides of its interval, half as long again.
fn around([low, high]: Range, value: f64, shape: &NonlinearParameter) -> Vec<Range> {
    const PIECES: usize = 32;
    const BEYOND: f64 = 1.6;
    let low = (value + BEYOND * (low - value)).max(shape.lower);
    let high = (value + BEYOND * (high - value)).min(shape.upper);
    let at = |k: usize| low + (high - low) * k as f64 / PIECES as f64;
    (0..PIECES).map(|k| [at(k), at(k + 1)]).collect()
}

/// Whitened squares with another value of one parameter, coefficients solved for anew.
fn height(picture: &Picture<'_>, theta: &[f64], k: usize, value: f64) -> Result<f64, IdentifyError> {
    let mut trial = theta.to_vec();
    trial[k] = value;
    left(&picture.beyond(picture.all(&trial)?), &picture.target)
}

/// How far up and down one parameter can go within its range before the squares are `allowed` above the least; `half` is about how far.
fn profile(
    picture: &Picture<'_>,
    shape: &NonlinearParameter,
    theta: &[f64],
    k: usize,
    (half, allowed): (f64, f64),
) -> Result<[f64; 2], IdentifyError> {
    /// Of the first step; how steps grow, and how finely an end is told.
    const FIRST: f64 = 0.25;
    const GROWS: f64 = 1.6;
    const FINE: f64 = 1e-3;
    let range = shape.upper - shape.lower;
    let half = half.clamp(1e-9 * range, 0.1 * range);
    let most = height(picture, theta, k, theta[k])? + allowed;
    let mut ends = [shape.lower, shape.upper];
    for end in &mut ends {
        let way = (*end - theta[k]).signum();
        let (mut inside, mut step) = (theta[k], FIRST * half);
        let mut outside = loop {
            if (*end - inside) * way <= 0.0 {
                break None;
            }
            let next = if (*end - inside).abs() <= step { *end } else { inside + way * step };
            if height(picture, theta, k, next)? > most {
                break Some(next);
            }
            (inside, step) = (next, step * GROWS);
        };
        while let Some(beyond) = outside.filter(|beyond| (beyond - inside).abs() > FINE * half) {
            let middle = 0.5 * (inside + beyond);
            if height(picture, theta, k, middle)? > most {
                outside = Some(middle);
            } else {
                inside = middle;
            }
        }
        *end = inside;
    }
    if picture.target.norm_squared() - (most - allowed) < WEAK {
        // Another valley may be as deep but for chance.
        for value in values(shape, picture.data, picture.chain()) {
            if (value < ends[0] || value > ends[1]) && height(picture, theta, k, value)? <= most {
                ends = [ends[0].min(value), ends[1].max(value)];
            }
        }
    }
    Ok(ends)
}
