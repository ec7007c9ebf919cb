//! The fit that is written: of all rows, with the structure that the search ended with.
//!
//! The structure is frozen; coefficients and nonlinear parameters come from all rows but the outliers. Where nothing was found, or what was
//! found was withdrawn, the fit is the one of the declared model by itself, as [`truepose_identify::fit`] makes it. A fit of all rows that does not
//! converge while that of the training rows did gives way to the latter.

use crate::data::payload::without;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::current::{Ground, Working};
use crate::model::nonlinear::{between_rows, descended, gaps, shapes};
use crate::problem::linearisation::Scene;
use crate::problem::outliers::{Outliers, outliers};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, NonlinearParameter};
use truepose_identify::{Fit, FitOptions, NoiseSource, fit, fit_again, judge_nonlinear};

/// The fit with what it was made from.
pub(crate) struct Final {
    pub fit: Fit,
    pub found: Vec<Candidate>,
    /// Without the rows that nothing explains.
    pub data: Dataset,
    pub outside: Outliers,
}

/// How the declared model is fitted by itself.
pub(crate) struct Plain<'a> {
    pub declared: &'a [Box<dyn AnyEffect>],
    pub fit: FitOptions,
    /// Whether a fit of all rows is wanted at all: inside a validation nobody uses it.
    pub thorough: bool,
}

impl Plain<'_> {
    /// The declared model on all rows.
    pub fn fit(&self, ground: &Ground<'_>, now: &Working, all: &Dataset) -> Result<Final, DiscoverError> {
        // Rows that are reported, and no others: else this would be another fit than the one that the user compares it with.
        let outside = outside(&now.fit, all, now)?;
        let data = without(all, &outside.certain);
        let model = ErrorModel::new(ground.chain.clone(), self.declared.to_vec())?;
        let mut fit = fit(&model, &data, ground.solver, &self.fit)?;
        let outside = self::outside(&fit, all, now)?;
        let data = without(all, &outside.certain);
        fit = fit_again(&fit, &data, ground.solver, &self.fit)?;
        Ok(Final { fit, found: Vec::new(), data, outside })
    }
}

/// The enlarged model on all rows, which `all` has with corrected loads.
pub(crate) fn enlarged(
    ground: &Ground<'_>,
    now: &Working,
    found: &[Candidate],
    all: &Dataset,
) -> Result<Final, DiscoverError> {
    let last_digits = FitOptions { flat: FitOptions::default().flat, ..ground.fit.clone() };
    let frozen = FitOptions { noise: NoiseSource::Fixed(now.fit.noise), ..last_digits };
    let mut first = outside(&now.fit, all, now)?;
    // Between the rows on either side of a jump the training rows cannot say who is out.
    let jumps: Vec<[f64; 2]> = between_rows(found, &now.data).iter().flat_map(gaps).collect();
    let unsure = |row: usize| jumps.iter().any(|[before, after]| (*before..*after).contains(&all.time[row]));
    first.suspects.retain(|&row| !unsure(row));
    let data = without(all, &first.suspects);
    let fit = fit_again(&now.fit, &data, ground.solver, &frozen)?;
    let moved = descended(ground, found, &fit, &data)?;
    let found = between_rows(moved.as_deref().unwrap_or(found), &data);
    let shapes = shapes(ground, &found, &data);
    let fit = if shapes.is_empty() { fit } else { ground.fitted_by(&found, &data, &frozen)? };
    let outside = outside(&fit, all, now)?;
    let data = without(all, &outside.suspects);
    let fit = if outside.suspects == first.suspects {
        fit
    } else {
        fit_again(&fit, &data, ground.solver, &frozen)?
    };
    if now.fit.converged && !fit.converged {
        return training(now, &now.found, all);
    }
    let fit = with_shapes(fit, &data, &shapes);
    Ok(Final { fit, found, data, outside })
}

/// The fit of the training rows as it stands.
pub(crate) fn training(now: &Working, found: &[Candidate], all: &Dataset) -> Result<Final, DiscoverError> {
    let outside = outside(&now.fit, all, now)?;
    let data = without(all, &outside.suspects);
    Ok(Final { fit: now.fit.clone(), found: found.to_vec(), data, outside })
}

/// Rows that a fit does not explain, by the noise of the training rows.
fn outside(fit: &Fit, all: &Dataset, now: &Working) -> Result<Outliers, DiscoverError> {
    let judged = Scene::new(fit, all)?;
    let residual = &judged.y - &judged.base * judged.coefficients();
    Ok(outliers(&judged, residual.as_slice(), now.fit.noise))
}

/// The fit with the intervals of what was found of the findings' nonlinear parameters, and with what those add to the covariance.
fn with_shapes(fit: Fit, data: &Dataset, shapes: &[(usize, NonlinearParameter)]) -> Fit {
    // Where columns beside the effect depend on each other nothing can be said: then the intervals are those of a known shape.
    if shapes.is_empty() { fit } else { judge_nonlinear(&fit, data, shapes).unwrap_or(fit) }
}
