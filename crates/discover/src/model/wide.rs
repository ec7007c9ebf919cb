//! Effects with rescaled expected sizes, which carry a prior width that was estimated from the data.
//!
//! The expected sizes of an effect's columns are multiplied by the ratio of the estimated prior standard
//! deviation to the nominal one. Each column of a declared effect gets the width of its variance group from
//! the fit of the declared model, so that findings do not change the prior of declared errors. All columns of
//! a finding get one width, 2 w of the contest: many weakly determined coefficients (a spline) are shrunk
//! towards zero, a single well determined one is not.

use truepose_errormodel::{AnyEffect, Term};
use truepose_identify::Fit;

/// The declared effects with the prior widths of the fit of the declared model, relative to its κ.
pub(crate) fn as_fitted(declared: &[Box<dyn AnyEffect>], fit: &Fit) -> Vec<Box<dyn AnyEffect>> {
    let model = fit.fitted.model();
    let widths = fit.prior.widths_of_columns(model);
    let mut wide: Vec<Box<dyn AnyEffect>> = Vec::new();
    for (k, effect) in declared.iter().enumerate() {
        wide.push(Box::new(Term::new(effect.clone()).scaled_each(widths[model.columns_of(k)].to_vec())));
    }
    wide
}
