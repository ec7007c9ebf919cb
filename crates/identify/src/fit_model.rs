//! The fit of a model, with the nonlinear parameters that its effects leave free.

use crate::fit::{Fit, FitOptions, NonlinearSearch, fit_fixed};
use crate::reduction::grouped;
use crate::{IdentifyError, shapes};
use truepose_errormodel::{Dataset, ErrorModel};
use truepose_solvers::Solver;

/// Fits a model to data, with the shape parameters that its effects leave free and the groups of a polynomial that reduces
/// first: the model of [`Fit::fitted`] holds them.
///
/// # Errors
/// When the data does not fit the model, nothing was measured, or the solver refuses.
pub fn fit(
    model: &ErrorModel,
    data: &Dataset,
    solver: &dyn Solver,
    options: &FitOptions,
) -> Result<Fit, IdentifyError> {
    options.validate()?;
    let model = &*grouped(model, data, options.rank)?;
    if options.shapes != NonlinearSearch::Fixed && shapes::wanted(model) {
        return shapes::fit(model, data, solver, options);
    }
    fit_fixed(model, &*data.derived_for(model)?, solver, options)
}
