//! Every strategy against plain least squares: nobody is better off with one that predicts worse.
//!
//! ```text
//! b² = mean over rows of min(d², (3 m)²)        d: held-out 3-D distance, m: its median with plain least squares
//! ```
//!
//! Bounded, because visits that are wrong lie far off whatever was fitted, and one of them more or less would decide.

use crate::fit::guarded;
use crate::{
    CrossValidation, Fit, FitOptions, Folds, IdentifyError, Method, Refusal, Residuals, Warning,
    cross_validate, fit,
};
use truepose_errormodel::{Dataset, ErrorModel};
use truepose_solvers::order::high_median;
use truepose_solvers::{Need, PivotedQr, Solver};

/// Bounded held-out error over that of plain least squares above which a strategy is worse, and no longer merely different: a robust
/// loss takes a twentieth of the efficiency, 2.6 % of the error of what is estimated, and of the whole error less.
pub(crate) const WORSE: f64 = 1.03;

/// Whether a strategy has to be held against plain least squares.
pub(crate) fn asked(solver: &dyn Solver, options: &FitOptions) -> bool {
    options.refine && !guarded(solver)
}

/// The plain fit, and what it predicts.
pub(crate) fn fitted(
    model: &ErrorModel,
    data: &Dataset,
    options: &FitOptions,
    folds: &Folds,
) -> Result<(Fit, CrossValidation), IdentifyError> {
    let plain = PivotedQr::default();
    let simplest = fit(model, data, &plain, options)?;
    let held_out = cross_validate(&simplest, data, folds, &plain, Method::Auto)?;
    Ok((simplest, held_out))
}

/// Bounded held-out error over that of plain least squares.
pub(crate) fn ratio(plain: &CrossValidation, other: &CrossValidation) -> f64 {
    let Some(median) = high_median(distances(&plain.residuals)) else { return 1.0 };
    let bounded = |residuals: &Residuals| {
        let of = distances(residuals);
        of.iter().map(|d| d.min(3.0 * median).powi(2)).sum::<f64>() / of.len().max(1) as f64
    };
    let (mine, theirs) = (bounded(&other.residuals), bounded(&plain.residuals));
    if theirs > 0.0 { (mine / theirs).sqrt() } else { 1.0 }
}

fn distances(residuals: &Residuals) -> Vec<f64> {
    (0..residuals.position.len()).filter_map(|row| residuals.distance(row)).collect()
}

/// The plain fit with the word, where a robust one has to give way; a penalty that was asked for stays, with the word.
pub(crate) fn judged(found: &mut Fit, solver: &dyn Solver, ratio: f64, plain: Fit) -> Option<Fit> {
    if ratio <= WORSE {
        return None;
    }
    let name = solver.name().to_owned();
    if !solver.supports(Need::Outliers) {
        found.warnings.push(Warning::WorseThanPlain { solver: name, ratio });
        return None;
    }
    let mut plain = plain;
    plain.warnings.push(Warning::FellBack { solver: name, why: Refusal::HeldOut(ratio) });
    Some(plain)
}
