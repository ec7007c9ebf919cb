//! Nonlinear parameters that were found elsewhere: brought to the bottom of their valley, and given their intervals.

use super::picture::{Picture, Trial};
use super::{interval, refine};
use crate::IdentifyError;
use crate::fit::{Fit, FittedNonlinear};
use truepose_errormodel::{Dataset, NonlinearParameter};

/// Visits that are looked at where shapes were found elsewhere.
const MOST_VISITS: usize = 1000;

/// Nonlinear parameters that were found elsewhere, one after the other perhaps, at the bottom of the valley in which they lie together: their
/// values, in the order of `found`, which are (effect, parameter at its value with the range in which it was looked for).
///
/// # Errors
/// As [`crate::fit()`].
pub fn descend_nonlinear(
    fit: &Fit,
    data: &Dataset,
    found: &[(usize, NonlinearParameter)],
) -> Result<Vec<f64>, IdentifyError> {
    let trial = Trial::new(fit.fitted.model(), found)?;
    let picture = Picture::on(fit, &trial, data, MOST_VISITS)?;
    let shapes: Vec<NonlinearParameter> = found.iter().map(|(_, shape)| shape.clone()).collect();
    let theta: Vec<f64> = shapes.iter().map(|shape| shape.value).collect();
    let every: Vec<usize> = (0..theta.len()).collect();
    refine::descend(&picture, &shapes, &theta, &every, false)
}

/// A fit whose shape parameters were found elsewhere, each with its interval, and with what their uncertainty adds to the variances of the coefficients.
/// `found` are (effect, parameter at its value with the range in which it was looked for); those of which the data says nothing beside
/// the others are taken as they stand, with their whole range. Of much data a part is looked at, for as much as the whole is worth.
///
/// # Errors
/// As [`crate::fit()`].
pub fn judge_nonlinear(
    fit: &Fit,
    data: &Dataset,
    found: &[(usize, NonlinearParameter)],
) -> Result<Fit, IdentifyError> {
    let mut free = found.to_vec();
    let mut given_up: Vec<FittedNonlinear> = Vec::new();
    while !free.is_empty() {
        let trial = Trial::new(fit.fitted.model(), &free)?;
        let picture = Picture::on(fit, &trial, data, MOST_VISITS)?;
        let theta: Vec<f64> = free.iter().map(|(_, shape)| shape.value).collect();
        let mut judged = fit.clone();
        judged.shapes.clear();
        interval::judge(&picture, &free, &theta, &mut judged)?;
        let (open, known): (Vec<FittedNonlinear>, Vec<FittedNonlinear>) =
            judged.shapes.drain(..).partition(FittedNonlinear::open);
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
