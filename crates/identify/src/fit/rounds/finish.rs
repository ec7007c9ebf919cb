//! What is made of the last round.

use super::state::{Outcome, State};
use crate::IdentifyError;
use crate::fit::result::Fit;
use crate::fit::warnings::Warning;
use crate::fit::{constraints, warnings};
use crate::reduction::Reduction;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::{Domain, FittedModel, NoiseModel};
use truepose_solvers::Need;
use truepose_solvers::order::high_median;

impl State<'_> {
    pub(in crate::fit) fn finish(self, reduction: Reduction, outcome: Outcome) -> Result<Fit, IdentifyError> {
        let columns = self.model.columns().len();
        let absolute = self.absolute(&reduction, &outcome.factor);
        let grouped = DVector::from_vec(reduction.grouped(&self.coefficients));
        let chi_square = absolute.residual_norm(0, &grouped).powi(2);
        let joined = self.prior.joined(&absolute, &vec![0.0; reduction.rank()])?;
        let inverse =
            joined.inverse_gram().unwrap_or_else(|| DMatrix::zeros(reduction.rank(), reduction.rank()));
        let covariance = spread_out(&inverse, &reduction.kept, columns);
        let typical = high_median(self.data.position_sd.iter().flatten().copied().filter(|v| !v.is_nan()));
        let turned = self.data.orientation.iter().any(Option::is_some);
        let noise = NoiseModel {
            position_sd: self.noise.position(typical.unwrap_or(f64::NAN)).hypot(self.noise.visit_sd),
            visit_sd: 0.0,
            orientation_sd: if turned { self.noise.orientation_sd } else { 0.0 },
        };
        let fitted = FittedModel::new(self.model.clone(), self.coefficients.clone(), covariance)?
            .with_channels(self.data.schema.channels.clone())
            .with_domain(Domain::of(self.data))
            .with_noise(noise)
            .with_repeatability(self.noise.visit_sd);
        let mut warnings = warnings::of(self.model, &reduction, self.observations);
        if !outcome.converged {
            warnings.push(Warning::NotConverged {
                rounds: outcome.rounds,
                all: outcome.rounds >= self.options.max_iterations,
            });
        }
        let mut fit = Fit {
            fitted,
            reduction,
            noise: self.noise,
            residuals: outcome.residuals,
            factor: absolute,
            prior: self.prior,
            rounds: outcome.rounds,
            converged: outcome.converged,
            refined: self.options.refine,
            observations: self.observations,
            chi_square,
            solution: outcome.solution,
            shapes: Vec::new(),
            unknown_shapes: Vec::new(),
            scatter: self.freedom.map(|known| known.2),
            warnings,
        };
        let (model, at) = (self.model, fit.fitted.coefficients());
        let more = match (self.solver.supports(Need::Bounds), self.solver.supports(Need::ColumnGroups)) {
            (false, false) => constraints::violated(model, &fit.reduction, at, &fit.half_widths()),
            (_, true) => constraints::left_out(model, &fit.reduction, at),
            _ => Vec::new(),
        };
        fit.warnings.extend(more);
        Ok(fit)
    }
}

/// A matrix over the kept columns, among all columns.
fn spread_out(inner: &DMatrix<f64>, kept: &[usize], columns: usize) -> DMatrix<f64> {
    let mut outer = DMatrix::zeros(columns, columns);
    for (i, &a) in kept.iter().enumerate() {
        for (j, &b) in kept.iter().enumerate() {
            outer[(a, b)] = inner[(i, j)];
        }
    }
    outer
}
