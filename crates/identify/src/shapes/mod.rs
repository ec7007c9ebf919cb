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

mod grid;
mod interval;
mod late;
mod mixture;
mod picture;
mod refine;
mod scan;

use crate::fit::fit_fixed;
use crate::{Fit, FitOptions, IdentifyError, Warning};
use picture::{Picture, Trial};
use std::collections::BTreeMap;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, Shape};
use truepose_solvers::Solver;

/// What is done about parameters in which an effect is not linear and that it leaves free ([`truepose_errormodel::Effect::shape`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shapes {
    /// They are taken as they stand.
    Fixed,
    /// Coefficients are solved for at every trial of them.
    #[default]
    Profiled,
    /// They are stepped together with the coefficients; the same optimum, for comparison.
    Joint,
}

/// A parameter that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedShape {
    /// Which effect of the model.
    pub effect: usize,
    /// Its name.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Value.
    pub value: f64,
    /// Its 95 % interval; of an instant between the last visit that can be before it and the first that can be after it.
    pub interval: [f64; 2],
    /// The range in which it was looked for.
    pub range: [f64; 2],
}

impl FittedShape {
    /// Whether the data leaves it open: the interval is the whole range.
    pub fn open(&self) -> bool {
        self.interval[0] <= self.range[0] && self.interval[1] >= self.range[1]
    }

    /// Whether it lies at an end of its range: the best value is then not inside.
    pub fn at_bound(&self) -> bool {
        let [lower, upper] = self.range;
        let near = 1e-6 * (upper - lower);
        self.value <= lower + near || self.value >= upper - near
    }
}

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
    let free: Vec<(usize, Shape)> = (0..model.effects().len())
        .flat_map(|k| model.effects()[k].shape().into_iter().map(move |shape| (k, shape)))
        .collect();
    let shapes: Vec<Shape> = free.iter().map(|(_, shape)| shape.clone()).collect();
    let start: Vec<f64> = shapes.iter().map(|s| s.value.clamp(s.lower, s.upper)).collect();
    let trial = Trial::new(model, &free)?;
    let rest: Vec<Box<dyn AnyEffect>> =
        model.effects().iter().filter(|effect| effect.shape().is_empty()).cloned().collect();
    let rest = ErrorModel::new(model.chain().clone(), rest)?;
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
        let next = refine::descend(&picture, &shapes, &theta, &every, options.shapes == Shapes::Joint)?;
        let spread = interval::deviations(&picture, &shapes, &theta)?;
        let moved = (0..theta.len()).map(|k| (next[k] - theta[k]).abs() / spread[k]).fold(0.0, f64::max);
        // A hundredth of a standard deviation is nothing; what then still shrinks is taken along.
        let done = moved < 1e-6 || (moved < 1e-2 && moved > 0.5 * moved_before) || round >= MOST_ROUNDS;
        if done {
            interval::judge(&picture, &free, &theta, &mut found)?;
            let bound = found.shapes.iter().filter(|s| s.at_bound());
            let more: Vec<Warning> = bound
                .map(|s| Warning::ShapeAtBound {
                    effect: now.effects()[s.effect].kind().into(),
                    name: s.name.clone(),
                    value: s.value,
                })
                .collect();
            found.warnings.extend(more);
            if moved > 1e-2 {
                found.warnings.push(Warning::NotConverged { rounds: found.rounds });
                found.converged = false;
            }
            return Ok(found);
        }
        moved_before = moved;
        theta = next;
    }
    Err(IdentifyError::NothingMeasured { rows: data.len() })
}

/// Visits that are looked at where shapes were found elsewhere.
const MOST_VISITS: usize = 1000;

/// Shape parameters that were found elsewhere, one after the other perhaps, at the bottom of the valley in which they lie together: their
/// values, in the order of `found`, which are (effect, parameter at its value with the range in which it was looked for).
///
/// # Errors
/// As [`crate::fit()`].
pub fn descend_shapes(
    fit: &Fit,
    data: &Dataset,
    found: &[(usize, Shape)],
) -> Result<Vec<f64>, IdentifyError> {
    let trial = Trial::new(fit.fitted.model(), found)?;
    let picture = Picture::on(fit, &trial, data, MOST_VISITS)?;
    let shapes: Vec<Shape> = found.iter().map(|(_, shape)| shape.clone()).collect();
    let theta: Vec<f64> = shapes.iter().map(|shape| shape.value).collect();
    let every: Vec<usize> = (0..theta.len()).collect();
    refine::descend(&picture, &shapes, &theta, &every, false)
}

/// A fit whose shape parameters were found elsewhere, each with its interval, and with what their uncertainty adds to the covariance.
/// `found` are (effect, parameter at its value with the range in which it was looked for); those of which the data says nothing beside
/// the others are taken as they stand, with their whole range. Of much data a part is looked at, for as much as the whole is worth.
///
/// # Errors
/// As [`crate::fit()`].
pub fn judge_shapes(fit: &Fit, data: &Dataset, found: &[(usize, Shape)]) -> Result<Fit, IdentifyError> {
    let mut free = found.to_vec();
    let mut given_up: Vec<FittedShape> = Vec::new();
    while !free.is_empty() {
        let trial = Trial::new(fit.fitted.model(), &free)?;
        let picture = Picture::on(fit, &trial, data, MOST_VISITS)?;
        let theta: Vec<f64> = free.iter().map(|(_, shape)| shape.value).collect();
        let mut judged = fit.clone();
        judged.shapes.clear();
        interval::judge(&picture, &free, &theta, &mut judged)?;
        let (open, known): (Vec<FittedShape>, Vec<FittedShape>) =
            judged.shapes.drain(..).partition(FittedShape::open);
        if open.is_empty() {
            judged.shapes = known;
            judged.shapes.append(&mut given_up);
            return Ok(judged);
        }
        free.retain(|(effect, shape)| !open.iter().any(|o| o.effect == *effect && o.name == shape.name));
        given_up.extend(open);
    }
    let mut judged = fit.clone();
    judged.shapes = given_up;
    Ok(judged)
}

/// The model with these values of its free parameters.
fn with(model: &ErrorModel, free: &[(usize, Shape)], theta: &[f64]) -> Result<ErrorModel, IdentifyError> {
    let mut values: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    free.iter().zip(theta).for_each(|((effect, _), value)| values.entry(*effect).or_default().push(*value));
    let effects = model.effects().iter().enumerate().map(|(k, effect)| match values.get(&k) {
        Some(values) => effect.with_shape(values),
        None => effect.clone(),
    });
    Ok(ErrorModel::new(model.chain().clone(), effects.collect())?)
}
