//! Effects with a prior that the data has set: as wide as their coefficients turned out to be.
//!
//! The expected sizes of an effect's columns are stretched so that the prior's standard deviation is that of a fit, or of a contest. Of the
//! declared effects each column gets the width of its kind (its family, in its unit) from the fit of the declared model: how far declared
//! errors lie from what was expected of them is not for the findings to say. Of a finding all columns get one width: many weakly
//! determined coefficients (a spline) are held together, a single clear one is left alone.

use truepose_errormodel::{AnyEffect, Term};
use truepose_identify::Fit;

/// The declared effects with the widths that the fit of the declared model gave to their columns, on top of its κ.
pub(crate) fn as_fitted(declared: &[Box<dyn AnyEffect>], fit: &Fit) -> Vec<Box<dyn AnyEffect>> {
    let model = fit.fitted.model();
    let widths = fit.prior.widths_of_columns(model);
    let mut wide: Vec<Box<dyn AnyEffect>> = Vec::new();
    for (k, effect) in declared.iter().enumerate() {
        wide.push(Box::new(Term::new(effect.clone()).scaled_each(widths[model.columns_of(k)].to_vec())));
    }
    wide
}
