//! How likely the data is with a candidate in the model: generalized least squares with the noise estimated again.
//!
//! ```text
//! −2 ln L = Σ ln det V + rᵀ V⁻¹ r + ‖W β‖² + ‖γ‖²/κ²,   r = y − A β − X γ,   V from τ and ρ of r
//! ```
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | β, γ | coefficients of the present model and of the candidate (in expected sizes) | r, k |
//! | τ, ρ | noise of a row and of a visit, estimated at r | 1 |
//! | κ | 100: holds only what the data leaves open | 1 |
//!
//! The noise has to be estimated for each rival by itself: a cause that leaves 0.02 mm of a visit's scatter and one that leaves
//! 0.1 mm look alike when both are weighed with the scatter from before.

use crate::error::DiscoverError;
use crate::problem::equations::{Equations, precision, solved, squares};
use crate::problem::linearisation::Linearisation;
use crate::problem::noise::Noise;
use crate::problem::residuals::as_residuals;
use crate::problem::restricted::Restricted;
use crate::statistics::coefficients::CoefficientDistribution;
use crate::statistics::product::gram_matrix;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use std::sync::OnceLock;
use truepose_errormodel::Visits;
use truepose_identify::{Folds, Freedom, NoiseModel, estimate_noise};

/// A model with a candidate's columns, fitted by generalized least squares.
#[derive(Clone)]
pub(crate) struct Likelihood {
    /// −2 ln L.
    pub deviance: f64,
    pub noise: Noise,
    /// γ, in expected sizes.
    pub coefficients: DVector<f64>,
    /// Covariance of γ.
    pub covariance: DMatrix<f64>,
    /// Raw X, m × k.
    extra: DMatrix<f64>,
    /// Prior standard deviation of γ, expected sizes.
    wide: f64,
    /// Precision that the priors add.
    prior: DMatrix<f64>,
    /// Raw and whitened [A | X | y], once they are needed.
    rows: OnceLock<(DMatrix<f64>, Equations)>,
}

/// γ with its covariance.
pub(crate) type Estimate = (DVector<f64>, DMatrix<f64>);

/// [A | X | y], raw.
pub(crate) fn joined(linearisation: &Linearisation<'_>, extra: &DMatrix<f64>) -> DMatrix<f64> {
    let (r, k) = (linearisation.base.ncols(), extra.ncols());
    let mut all = DMatrix::zeros(linearisation.len(), r + k + 1);
    all.columns_mut(0, r).copy_from(&linearisation.base);
    all.columns_mut(r, k).copy_from(extra);
    all.column_mut(r + k).copy_from(&linearisation.y);
    all
}

impl Likelihood {
    /// Of the present model with these raw columns added (m × k; k may be zero).
    pub fn new(
        linearisation: &Linearisation<'_>,
        extra: &DMatrix<f64>,
        visits: &Visits,
    ) -> Result<Self, DiscoverError> {
        let (r, k) = (linearisation.base.ncols(), extra.ncols());
        let n = r + k;
        let prior =
            precision(linearisation.prior_precision(), &Vec::from_iter(0..r), k, linearisation.policy.wide);
        if linearisation.noise.joints.is_some()
            && let Some(found) = Likelihood::beside_joints(linearisation, extra, &prior)
        {
            return Ok(found);
        }
        let known = linearisation.normal().map(|normal| (normal, normal.candidate_products(extra)));
        let gram = |noise: NoiseModel| match &known {
            Some((normal, candidate)) => normal.gram(noise, candidate),
            None => {
                let whitener = linearisation.whitener(noise);
                let white = whitener.of(&joined(linearisation, extra));
                (gram_matrix(&white), whitener.log_determinant())
            }
        };
        // One share for all: rivals are held against each other, and what each takes of it differs by a trifle.
        let left = |unknowns: f64| {
            let share = (1.0 - unknowns / linearisation.len().max(1) as f64).max(0.02);
            Freedom::all(linearisation.data, visits).share(share)
        };
        let mut noise = linearisation.noise.rows;
        let mut iterations = 0;
        loop {
            let (gram, log_determinant) = gram(noise);
            let (solution, factor) = solved(&gram, &prior)?;
            let residual =
                &linearisation.y - &linearisation.base * solution.rows(0, r) - extra * solution.rows(r, k);
            let wander = linearisation.wander();
            let freedom = match wander.is_empty() {
                true => left(n as f64),
                // Its prior holds a wander: it takes fewer degrees of freedom than it has columns.
                false => left((n - wander.len()) as f64 + factor.determined(wander, &prior)),
            };
            let again =
                estimate_noise(linearisation.data, visits, &as_residuals(linearisation, &residual), &freedom);
            iterations += 1;
            if iterations < linearisation.budget.noise_iterations && !near(&noise, &again) {
                noise = again;
                continue;
            }
            let penalty = (&prior * &solution).dot(&solution);
            return Ok(Likelihood {
                deviance: log_determinant + squares(&gram, &solution) + penalty,
                noise: noise.into(),
                coefficients: solution.rows(r, k).into_owned(),
                covariance: factor.covariance(r),
                extra: extra.clone(),
                wide: linearisation.policy.wide,
                prior,
                rows: OnceLock::new(),
            });
        }
    }

    /// The same where the joints scatter: all components of the noise by restricted likelihood. None where the candidate's columns are not
    /// finite or all alike.
    fn beside_joints(
        linearisation: &Linearisation<'_>,
        extra: &DMatrix<f64>,
        prior: &DMatrix<f64>,
    ) -> Option<Self> {
        let wide = linearisation.policy.wide;
        let found = Restricted::new(linearisation, extra, 1.0 / (wide * wide)).on_grid()?;
        Some(Likelihood {
            deviance: found.deviance,
            noise: found.noise(),
            coefficients: found.coefficients,
            covariance: found.covariance,
            extra: extra.clone(),
            wide,
            prior: prior.clone(),
            rows: OnceLock::new(),
        })
    }

    /// Standard deviation of one of γ.
    pub fn deviation(&self, at: usize) -> f64 {
        self.covariance[(at, at)].max(0.0).sqrt()
    }

    /// The distribution from which these of γ look drawn.
    pub fn coefficient_distribution(&self, which: Range<usize>) -> CoefficientDistribution {
        let (first, count) = (which.start, which.len());
        let coefficients = self.coefficients.rows(first, count).into_owned();
        CoefficientDistribution::of(
            &coefficients,
            &self.covariance.view((first, first), (count, count)).into_owned(),
            self.wide,
        )
    }

    fn rows(&self, linearisation: &Linearisation<'_>) -> &(DMatrix<f64>, Equations) {
        self.rows.get_or_init(|| {
            let raw = joined(linearisation, &self.extra);
            let white = linearisation.whitener(self.noise).of(&raw);
            (raw, Equations::new(white))
        })
    }

    /// Residuals of every measured number by a fit that did not see its fold, m or rad; γ is held within `width` expected sizes, as it will
    /// be in the model: where a fold leaves a piece of a curve open, nothing is claimed there.
    pub fn held_out(
        &self,
        linearisation: &Linearisation<'_>,
        folds: &Folds,
        width: f64,
    ) -> Result<Vec<f64>, DiscoverError> {
        let (raw, equations) = self.rows(linearisation);
        let n = raw.ncols() - 1;
        let mut prior = self.prior.clone();
        for at in n - self.extra.ncols()..n {
            prior[(at, at)] = width.min(linearisation.policy.wide).powi(-2);
        }
        let mut by_fold = vec![Vec::new(); folds.count];
        for (at, o) in linearisation.observations.iter().enumerate() {
            by_fold[folds.of_visit[o.visit]].push(at);
        }
        // What wandered while the others were measured is no prediction.
        let wander = linearisation.wander();
        let mut residual = vec![f64::NAN; linearisation.len()];
        for members in &by_fold {
            let (solution, _) = solved(&equations.without(members), &prior)?;
            for &at in members {
                let row = raw.row(at);
                let all = row.iter().take(n).zip(solution.iter()).map(|(a, b)| a * b).enumerate();
                let predicted: f64 = all.filter(|(k, _)| !wander.contains(k)).map(|(_, part)| part).sum();
                residual[at] = row[n] - predicted;
            }
        }
        Ok(residual)
    }

    /// γ from these visits only, and from all others only.
    pub fn on_halves(
        &self,
        linearisation: &Linearisation<'_>,
        visits: &[bool],
        unknowns: usize,
    ) -> Result<[Estimate; 2], DiscoverError> {
        let (raw, equations) = self.rows(linearisation);
        let first = raw.ncols() - 1 - unknowns;
        let (own, others): (Vec<usize>, Vec<usize>) =
            (0..linearisation.len()).partition(|&at| visits[linearisation.observations[at].visit]);
        let of = |members: &[usize]| -> Result<Estimate, DiscoverError> {
            let (solution, factor) = solved(&equations.of(members), &self.prior)?;
            Ok((solution.rows(first, unknowns).into_owned(), factor.covariance(first)))
        };
        Ok([of(&own)?, of(&others)?])
    }
}

fn near(a: &NoiseModel, b: &NoiseModel) -> bool {
    let close = |a: f64, b: f64| (a - b).abs() <= 0.02 * (a.abs() + b.abs()) + 1e-10;
    close(a.position_sd, b.position_sd)
        && close(a.visit_sd, b.visit_sd)
        && close(a.orientation_sd, b.orientation_sd)
}

/// The same data and the same real robot, as a model sees it that lacks some of its effects; the noise is estimated again. None when
/// the effects that stay are entangled with those that go.
pub(crate) fn without<'a>(
    linearisation: Linearisation<'a>,
    effects: Range<usize>,
) -> Result<Option<Linearisation<'a>>, DiscoverError> {
    let Some(mut linearisation) = linearisation.muting(effects) else { return Ok(None) };
    let nothing = DMatrix::zeros(linearisation.len(), 0);
    linearisation.noise = Likelihood::new(&linearisation, &nothing, &Visits::of(linearisation.data))?.noise;
    Ok(Some(linearisation))
}
