//! Parameters in which an effect is not linear, found by variable projection: a period, a time constant, an instant.
//!
//! r(θ) = (I − Q Qᵀ)(y − X(θ) b(θ)),  b(θ) = X̃(θ)⁺ ỹ,  X̃ = (I − Q Qᵀ) X
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | θ | shape parameters of all effects that leave some free | q |
//! | X(θ) | whitened columns of those effects, at the exact robot | m × k |
//! | Q | basis of all other columns, with the rows of the prior | m × r |
//! | y | whitened `r + A c` | m |
//!
//! The rest of the model is fitted first. Then each θ is looked for on a grid over its whole range ([`grid`]), dense enough
//! that no valley is missed; the best valleys are descended into (Golub and Pereyra 1973), the model is fitted with the θ
//! found, and both are repeated at the new solution until θ stays. Instants have no slope: every gap between two visits is
//! tried. Intervals of θ, and what its uncertainty adds to the coefficients, follow from the same linear picture
//! ([`interval`]).

use super::picture::{Picture, Trial};
use super::{interval, refine, scan};
use crate::IdentifyError;
use crate::fit::{Fit, FitOptions, NonlinearSearch, Warning, fit_fixed};
use std::collections::BTreeMap;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, NonlinearParameter};
use truepose_solvers::Solver;

/// Rounds of fit and search at most.
const MOST_ROUNDS: usize = 12;

/// Whether a model leaves a parameter free.
pub(crate) fn wanted(model: &ErrorModel) -> bool {
    model.effects().iter().any(|effect| !effect.shape().is_empty())
}

/// Fits a model and its free shape parameters.
pub(crate) fn fit(
    model: &ErrorModel,
    data: &Dataset,
    solver: &dyn Solver,
    options: &FitOptions,
) -> Result<Fit, IdentifyError> {
    let free: Vec<(usize, NonlinearParameter)> = (0..model.effects().len())
        .flat_map(|k| model.effects()[k].shape().into_iter().map(move |shape| (k, shape)))
        .collect();
    let shapes: Vec<NonlinearParameter> = free.iter().map(|(_, shape)| shape.clone()).collect();
    let start: Vec<f64> = shapes.iter().map(|s| s.value.clamp(s.lower, s.upper)).collect();
    let trial = Trial::new(model, &free)?;
    let rest: Vec<Box<dyn AnyEffect>> =
        model.effects().iter().filter(|effect| effect.shape().is_empty()).cloned().collect();
    let rest = ErrorModel::new(model.shared_chain(), rest)?;
    let base = if rest.columns().is_empty() {
        None
    } else {
        let derived = data.derived_for(&rest)?;
        Some(fit_fixed(&rest, &derived, solver, options)?)
    };
    let picture = Picture::without(&rest, base.as_ref(), &trial, data, scan::VISITS, options)?;
    let mut theta = scan::best(&picture, &shapes, &start)?;
    let every: Vec<usize> = (0..shapes.len()).collect();
    let mut moved_before = f64::INFINITY;
    for round in 1.. {
        let now = with(model, &free, &theta)?;
        let derived = data.derived_for(&now)?;
        let mut found = fit_fixed(&now, &derived, solver, options)?;
        let picture = Picture::at(&found, &trial, data)?;
        let next =
            refine::descend(&picture, &shapes, &theta, &every, options.shapes == NonlinearSearch::Joint)?;
        let spread = interval::deviations(&picture, &shapes, &theta)?;
        let moved = (0..theta.len()).map(|k| (next[k] - theta[k]).abs() / spread[k]).fold(0.0, f64::max);
        // A hundredth of a standard deviation is nothing; what then still shrinks is taken along.
        let done = moved < 1e-6 || (moved < 1e-2 && moved > 0.5 * moved_before) || round >= MOST_ROUNDS;
        if done {
            interval::judge(&picture, &free, &theta, &mut found)?;
            let bound = found.shapes.iter().filter(|s| s.at_bound());
            let more: Vec<Warning> = bound
                .map(|s| Warning::NonlinearAtBound {
                    effect: now.effects()[s.effect].kind().into(),
                    name: s.name.clone(),
                    value: s.value,
                })
                .collect();
            found.warnings.extend(more);
            if moved > 1e-2 {
                found.warnings.push(Warning::NotConverged { rounds: found.rounds, all: true });
                found.converged = false;
            }
            return Ok(found);
        }
        moved_before = moved;
        theta = next;
    }
    Err(IdentifyError::NothingMeasured { rows: data.len() })
}

/// The model with these values of its free parameters.
fn with(
    model: &ErrorModel,
    free: &[(usize, NonlinearParameter)],
    theta: &[f64],
) -> Result<ErrorModel, IdentifyError> {
    let mut values: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    free.iter().zip(theta).for_each(|((effect, _), value)| values.entry(*effect).or_default().push(*value));
    let effects = model.effects().iter().enumerate().map(|(k, effect)| match values.get(&k) {
        Some(values) => effect.with_nonlinear(values),
        None => effect.clone(),
    });
    Ok(ErrorModel::new(model.shared_chain(), effects.collect())?)
}
