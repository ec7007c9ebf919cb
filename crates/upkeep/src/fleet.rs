//! Robots of one type as prior for the next.
//!
//! ```text
//! μ = (1/n) Σ c_i                                     c_i: coefficients of robot i
//! S = Σ (c_i − μ)(c_i − μ)ᵀ / (n − 1)
//! v_k = S_kk − C̄_kk, at least S_kk/20                C̄: mean covariance of the fits
//! Σ_ij = f (1 − λ) r_ij √(v_i v_j),  Σ_ii = f v_i      r: correlations of S;  f = (1 + 1/n) (n − 1)/(n − 3)
//! ```
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | λ | [`Fleet::shrinkage`] | 1 | 1 |
//! | μ, Σ | coefficients and covariance of [`Fleet::prior`] | p, p × p | of the coefficients |
//!
//! λ is the estimate of Schäfer and Strimmer (2005), which makes correlations of a few robots worth what they are: n robots have at most
//! n − 1 directions. f makes of the sample's covariance that of the next robot: its mean is not known exactly, and neither is Σ (variance of
//! the multivariate t distribution). What each fit leaves open is part of the scatter S of estimates and none of the robots: its mean is taken off.

use crate::UpkeepError;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::{FittedModel, NoiseModel};

/// What robots of one type have in common.
#[derive(Debug, Clone)]
pub struct Fleet {
    /// A fit with the mean errors of the fleet, and as covariance their scatter from robot to robot.
    pub prior: FittedModel,
    /// How many robots.
    pub robots: usize,
    /// λ.
    pub shrinkage: f64,
}

/// Fewest robots of which a scatter is known: f is finite.
const FEWEST: usize = 4;

/// Share of the scatter of estimates that is put down to the robots at least: ten of them leave it open to about a half.
const LEAST_SHARE: f64 = 0.05;

/// The prior for the next robot of these.
///
/// # Errors
/// [`UpkeepError::Fleet`] where there are fewer than four fits, or one is of another robot or another model; counts from one.
pub fn fleet(fits: &[FittedModel]) -> Result<Fleet, UpkeepError> {
    let n = fits.len();
    if n < FEWEST {
        let why = format!("{n} fits are no fleet: the scatter from robot to robot takes {FEWEST} at least");
        return Err(UpkeepError::Fleet { why });
    }
    for (number, fit) in (1..).zip(fits) {
        if let Some(difference) = difference(&fits[0], fit) {
            return Err(UpkeepError::Fleet {
                why: format!("fit {number} is not of the type of fit 1: {difference}"),
            });
        }
    }
    // The same fit twice is one robot: its scatter would count for less than it is.
    for (k, fit) in fits.iter().enumerate() {
        let same = |other: &FittedModel| {
            !fit.coefficients().is_empty()
                && other.coefficients() == fit.coefficients()
                && other.covariance() == fit.covariance()
        };
        if let Some(other) = fits[..k].iter().position(same) {
            let why = format!("fits {} and {} are the same fit; each robot counts once", other + 1, k + 1);
            return Err(UpkeepError::Fleet { why });
        }
    }
    let p = fits[0].coefficients().len();
    let column = |fit: &FittedModel| DVector::from_column_slice(fit.coefficients());
    let mean = fits.iter().map(column).sum::<DVector<f64>>() / n as f64;
    let away = DMatrix::from_columns(&fits.iter().map(|fit| column(fit) - &mean).collect::<Vec<_>>());
    let scatter = &away * away.transpose() / (n - 1) as f64;
    let shrinkage = shrinkage(&away, &scatter);
    let count = n as f64;
    let next = (1.0 + 1.0 / count) * (count - 1.0) / (count - 3.0);
    let open = |k: usize| fits.iter().map(|fit| fit.covariance()[(k, k)]).sum::<f64>() / count;
    let share: Vec<f64> = (0..p)
        .map(|k| match scatter[(k, k)] {
            variance if variance > 0.0 => ((variance - open(k)) / variance).max(LEAST_SHARE).sqrt(),
            _ => 0.0,
        })
        .collect();
    let kept = |i: usize, j: usize| if i == j { 1.0 } else { 1.0 - shrinkage };
    let covariance = DMatrix::from_fn(p, p, |i, j| next * scatter[(i, j)] * share[i] * share[j] * kept(i, j));
    let squares = |of: fn(&NoiseModel) -> f64| {
        (fits.iter().map(|fit| of(&fit.noise).powi(2)).sum::<f64>() / count).sqrt()
    };
    let noise = NoiseModel {
        position_sd: squares(|noise| noise.position_sd),
        orientation_sd: squares(|noise| noise.orientation_sd),
        ..fits[0].noise
    };
    let repeatability = (fits.iter().map(|fit| fit.repeatability_sd.powi(2)).sum::<f64>() / count).sqrt();
    let mut domain = fits[0].domain.clone();
    fits[1..].iter().for_each(|fit| domain.widen(&fit.domain));
    // Rows of one robot are no rows of another.
    domain.sample = Default::default();
    let prior = FittedModel::new(fits[0].model().clone(), mean.as_slice().to_vec(), covariance)?
        .with_channels(fits[0].channels.clone())
        .with_domain(domain)
        .with_noise(noise)
        .with_repeatability(repeatability);
    Ok(Fleet { prior, robots: n, shrinkage })
}

/// In what two fits differ that sisters have in common.
fn difference(first: &FittedModel, other: &FittedModel) -> Option<String> {
    let (a, b) = (first.chain(), other.chain());
    if a.joints().len() != b.joints().len() {
        return Some(format!("it has {} joints, not {}", b.joints().len(), a.joints().len()));
    }
    if let Some((own, _)) = b.joints().iter().zip(a.joints()).find(|(own, of_first)| own != of_first) {
        return Some(format!("its joint {} is described otherwise", own.name));
    }
    let names = |fit: &FittedModel| -> Vec<String> {
        fit.model().columns().iter().map(|column| column.name.clone()).collect()
    };
    let (of_first, own) = (names(first), names(other));
    if let Some(missing) = of_first.iter().find(|name| !own.contains(name)) {
        return Some(format!("its model lacks `{missing}`"));
    }
    if let Some((own, _)) = own.iter().zip(&of_first).find(|(own, of_first)| own != of_first) {
        return Some(format!("its model has `{own}` besides; identify all robots with one model"));
    }
    // Two sines of other periods have coefficients of one name, and no mean.
    let settings = |fit: &FittedModel| -> Vec<String> {
        fit.model()
            .effects()
            .iter()
            .map(|effect| format!("`{} {}`", effect.kind(), effect.parameters()))
            .collect()
    };
    settings(other)
        .into_iter()
        .zip(settings(first))
        .find(|(own, of_first)| own != of_first)
        .map(|(own, of_first)| format!("its model has {own}, that of fit 1 {of_first}; hold such parameters"))
}

/// λ = Σ_{i≠j} var(r_ij) / Σ_{i≠j} r_ij², between 0 and 1, over correlations r; `away` are deviations from the mean, robot by robot.
fn shrinkage(away: &DMatrix<f64>, scatter: &DMatrix<f64>) -> f64 {
    let n = away.ncols() as f64;
    let free: Vec<usize> = (0..away.nrows()).filter(|&k| scatter[(k, k)] > 0.0).collect();
    let unit = |k: usize, robot: usize| away[(k, robot)] / scatter[(k, k)].sqrt();
    let (mut variance, mut square) = (0.0, 0.0);
    for (at, &i) in free.iter().enumerate() {
        for &j in &free[..at] {
            let products: Vec<f64> = (0..away.ncols()).map(|robot| unit(i, robot) * unit(j, robot)).collect();
            let mean = products.iter().sum::<f64>() / n;
            let spread = products.iter().map(|w| (w - mean).powi(2)).sum::<f64>();
            variance += n / (n - 1.0).powi(3) * spread;
            square += (n / (n - 1.0) * mean).powi(2);
        }
    }
    if square > 0.0 { (variance / square).clamp(0.0, 1.0) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn correlations_of_independent_numbers_are_shrunk_and_real_ones_stay() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let robots = 12;
        let mut noise = || -> f64 { (0..12).map(|_| rng.random_range(-0.5..0.5)).sum() };
        let apart = DMatrix::from_fn(30, robots, |_, _| noise());
        let common: Vec<f64> = (0..robots).map(|_| noise()).collect();
        let together =
            DMatrix::from_fn(30, robots, |k, robot| (k as f64 + 1.0) * (common[robot] + 0.1 * noise()));
        let of = |values: &DMatrix<f64>| {
            let mean = values.column_mean();
            let away = DMatrix::from_fn(values.nrows(), robots, |k, robot| values[(k, robot)] - mean[k]);
            shrinkage(&away, &(&away * away.transpose() / (robots - 1) as f64))
        };
        assert!(of(&apart) > 0.7, "{}", of(&apart));
        assert!(of(&together) < 0.4, "{}", of(&together));
    }
}
