//! One step from the normal equations of data that is nowhere whole, with the structure that a sample of it has.

use super::state::{Outcome, State};
use crate::fit::options::FitOptions;
use crate::fit::result::Fit;
use crate::reduction::Reduction;
use crate::{IdentifyError, Residuals};
use nalgebra::DVector;
use truepose_errormodel::{Dataset, Visits};
use truepose_solvers::Solver;
use truepose_solvers::accumulator::Factor;

/// The fit that all of the data gives, and how far the step to it is (relative, whitened): `factor` is its triangular factor over the kept columns, linearised at `at` with the noise of the fit
/// of a sample. Reduction, prior and noise stay what they are. Residuals are left empty.
pub(crate) fn from_factor(
    fit: &Fit,
    sample: &Dataset,
    solver: &dyn Solver,
    options: &FitOptions,
    at: &[f64],
    factor: &Factor,
    observations: usize,
) -> Result<(Fit, f64), IdentifyError> {
    let model = fit.fitted.model();
    let visits = Visits::of(sample);
    let mut state = State::new(model, sample, &visits, solver, options)?;
    state.noise = fit.noise;
    state.prior = fit.prior.clone();
    state.coefficients = at.to_vec();
    state.observations = observations;
    let reduction: &Reduction = &fit.reduction;
    let scales: Vec<f64> = reduction.kept.iter().map(|&c| model.columns()[c].scale).collect();
    let (solution, target) = state.solve(reduction, factor, &scales, 0.0)?;
    let change: Vec<f64> =
        reduction.grouped(&target).iter().zip(reduction.grouped(at)).map(|(to, from)| to - from).collect();
    let mut there = factor.clone();
    let moved = &there.r * DVector::from_vec(change);
    there.z.column_mut(0).zip_apply(&moved, |z, s| *z -= s);
    let length = state.step(reduction, factor, &target);
    state.coefficients = target;
    let outcome =
        Outcome { solution, rounds: 1, converged: true, factor: there, residuals: Residuals::default() };
    let mut whole = state.finish(reduction.clone(), outcome)?;
    whole.shapes.clone_from(&fit.shapes);
    Ok((whole, length))
}
