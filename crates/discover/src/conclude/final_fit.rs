//! The final fit: of all rows, with the structure of the search.
//!
//! The structure is fixed; coefficients and nonlinear parameters are estimated from all rows except outliers.
//! Without findings, or when they were withdrawn, it is the fit of the declared model as
//! [`truepose_identify::fit`] makes it. When the fit of all rows does not converge and that of the training
//! rows did, the latter is returned.

use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::current::{Context, ModelFit};
use crate::model::nonlinear::{between_rows, descended, gaps, nonlinear_parameters};
use crate::model::prepared::without;
use crate::problem::linearisation::Linearisation;
use crate::problem::outliers::{Outliers, outliers};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, NonlinearParameter};
use truepose_identify::{Fit, FitOptions, NoiseSource, fit, fit_again, judge_nonlinear};

/// The final fit with its data.
pub(crate) struct Final {
    pub fit: Fit,
    pub found: Vec<Candidate>,
    /// Without outliers.
    pub data: Dataset,
    pub outside: Outliers,
}

/// How the declared model is fitted alone.
pub(crate) struct DeclaredFit<'a> {
    pub declared: &'a [Box<dyn AnyEffect>],
    pub fit: FitOptions,
    /// Whether the fit of all rows, competing hypotheses and partial residuals are wanted; a cross-validation
    /// does not use them.
    pub full_report: bool,
}

impl DeclaredFit<'_> {
    /// The declared model fitted to all rows.
    ///
    /// # Errors
    /// When the fit fails.
    pub fn fit(
        &self,
        context: &Context<'_>,
        current: &ModelFit,
        all: &Dataset,
    ) -> Result<Final, DiscoverError> {
        // Suspect rows have no influence, reported or not; without any the fit is the one of `identify`.
        let outside = outside(context, &current.fit, all, current)?;
        let data = without(all, &outside.suspects);
        let model = ErrorModel::new(context.chain.clone(), self.declared.to_vec())?;
        let mut fit = fit(&model, &data, context.solver, &self.fit)?;
        let outside = self::outside(context, &fit, all, current)?;
        let data = without(all, &outside.suspects);
        fit = fit_again(&fit, &data, context.solver, &self.fit)?;
        Ok(Final { fit, found: Vec::new(), data, outside })
    }
}

/// The enlarged model fitted to all rows; `all` has corrected payloads.
pub(crate) fn enlarged(
    context: &Context<'_>,
    current: &ModelFit,
    found: &[Candidate],
    all: &Dataset,
) -> Result<Final, DiscoverError> {
    let last_digits = FitOptions { flat: FitOptions::default().flat, ..context.fit.clone() };
    let frozen = FitOptions { noise: NoiseSource::Fixed(current.fit.noise), ..last_digits };
    let mut first = outside(context, &current.fit, all, current)?;
    // Between the training rows before and after a change point no row can be called an outlier.
    let jumps: Vec<[f64; 2]> = between_rows(found, &current.data).iter().flat_map(gaps).collect();
    let unsure = |row: usize| jumps.iter().any(|[before, after]| (*before..*after).contains(&all.time[row]));
    first.suspects.retain(|&row| !unsure(row));
    let data = without(all, &first.suspects);
    let fit = fit_again(&current.fit, &data, context.solver, &frozen)?;
    let moved = descended(context, found, &fit, &data)?;
    let found = between_rows(moved.as_deref().unwrap_or(found), &data);
    let nonlinear = nonlinear_parameters(context, &found, &data);
    let fit = if nonlinear.is_empty() { fit } else { context.fitted_by(&found, &data, &frozen)? };
    let outside = outside(context, &fit, all, current)?;
    let data = without(all, &outside.suspects);
    let fit = if outside.suspects == first.suspects {
        fit
    } else {
        fit_again(&fit, &data, context.solver, &frozen)?
    };
    if current.fit.converged && !fit.converged {
        return training(context, current, &current.found, all);
    }
    let fit = with_nonlinear(fit, &data, &nonlinear);
    Ok(Final { fit, found, data, outside })
}

/// The fit of the training rows.
pub(crate) fn training(
    context: &Context<'_>,
    current: &ModelFit,
    found: &[Candidate],
    all: &Dataset,
) -> Result<Final, DiscoverError> {
    let outside = outside(context, &current.fit, all, current)?;
    let data = without(all, &outside.suspects);
    Ok(Final { fit: current.fit.clone(), found: found.to_vec(), data, outside })
}

/// Outliers of a fit, with the noise of the training rows.
fn outside(
    context: &Context<'_>,
    fit: &Fit,
    all: &Dataset,
    current: &ModelFit,
) -> Result<Outliers, DiscoverError> {
    let judged = Linearisation::new(fit, all, context.options)?;
    let residual = &judged.y - &judged.base * judged.coefficients();
    Ok(outliers(&judged, residual.as_slice(), current.fit.noise))
}

/// The fit with intervals of the nonlinear parameters of the findings, and with their contribution to the
/// covariance.
fn with_nonlinear(fit: Fit, data: &Dataset, nonlinear: &[(usize, NonlinearParameter)]) -> Fit {
    // Where columns are linearly dependent no interval is computed; the covariance is that of known nonlinear
    // parameters.
    if nonlinear.is_empty() { fit } else { judge_nonlinear(&fit, data, nonlinear).unwrap_or(fit) }
}
