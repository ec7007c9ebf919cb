//! Everything that a fit has while it runs.

use crate::fit::options::{FitOptions, NoiseSource};
use crate::freedom::{Freedom, Taken};
use crate::linearise::{factorise, gram, misfit};
use crate::reduction::Reduction;
use crate::{IdentifyError, NoiseModel, Prior, PriorStrength, Residuals};
use nalgebra::DVector;
use truepose_errormodel::{Dataset, ErrorModel, Visits};
use truepose_solvers::accumulator::Factor;
use truepose_solvers::{Need, Solution, Solver};

/// Condition number of the columns, brought to length one, up to which sums of products hold half the digits.
const CONDITION: f64 = 1e5;
/// Relative step below which nothing moves.
pub(super) const STILL: f64 = 1e-8;
/// Share of its standard deviation by which no unknown moves any more.
pub(super) const STILL_DEVIATIONS: f64 = 1e-3;
/// What the objective may rise by in a step: weights follow the posture from round to round only. As a share, and in units.
pub(super) const WORSE: f64 = 1e-6;
pub(super) const TRIFLE: f64 = 1e-3;

/// Everything that a fit has while it runs.
pub(in crate::fit) struct State<'a> {
    pub(super) model: &'a ErrorModel,
    pub(super) data: &'a Dataset,
    pub(super) visits: &'a Visits,
    pub(super) solver: &'a dyn Solver,
    pub(in crate::fit) options: FitOptions,
    pub(super) observations: usize,
    pub(super) noise: NoiseModel,
    pub(in crate::fit) prior: Prior,
    pub(in crate::fit) coefficients: Vec<f64>,
    /// Whether the data has not yet been asked for the noise and the prior.
    pub(in crate::fit) unseen: bool,
    /// Whether sums of products have held the digits of every factor so far.
    pub(super) sums_hold: bool,
    /// What the unknowns leave to scatter, with the noise and the number of unknowns at which that was asked.
    pub(super) freedom: Option<(NoiseModel, usize, Freedom)>,
}

/// How the rounds ended.
pub(in crate::fit) struct Outcome {
    pub(super) solution: Solution,
    pub(in crate::fit) rounds: usize,
    pub(super) converged: bool,
    /// At the last coefficients, over the kept columns.
    pub(super) factor: Factor,
    /// At the last coefficients.
    pub(super) residuals: Residuals,
}

impl Outcome {
    /// Whether the last round moved nothing any more.
    pub(in crate::fit) fn converged(&self) -> bool {
        self.converged
    }
}

impl<'a> State<'a> {
    /// The model.
    pub(in crate::fit) fn fitted_model(&self) -> &'a ErrorModel {
        self.model
    }

    pub(in crate::fit) fn new(
        model: &'a ErrorModel,
        data: &'a Dataset,
        visits: &'a Visits,
        solver: &'a dyn Solver,
        options: &FitOptions,
    ) -> Result<Self, IdentifyError> {
        options.validate()?;
        data.validate(model.chain())?;
        let observations: usize = (0..data.len()).map(|row| data.seen(row).count()).sum();
        if observations == 0 {
            return Err(IdentifyError::NothingMeasured { rows: data.len() });
        }
        let noise = match options.noise {
            NoiseSource::Estimate => NoiseModel::default(),
            NoiseSource::Fixed(noise) => noise,
        };
        let coefficients = vec![0.0; model.columns().len()];
        let (prior, options) = (Prior::none(), options.clone());
        Ok(State {
            model,
            data,
            visits,
            solver,
            options,
            observations,
            noise,
            prior,
            coefficients,
            unseen: true,
            sums_hold: true,
            freedom: None,
        })
    }

    /// Over all columns, or over these.
    pub(in crate::fit) fn linearise(&self, columns: Option<&[usize]>) -> Result<Factor, IdentifyError> {
        factorise(self.model, self.data, self.visits, self.noise, &self.coefficients, columns)
    }

    /// Over these columns on the way, for a correction of a step.
    pub(super) fn passing_over(&self, columns: &[usize]) -> Result<Factor, IdentifyError> {
        let (model, data, visits, at) = (self.model, self.data, self.visits, &*self.coefficients);
        let sums = gram(model, data, visits, self.noise, at, Some(columns))?;
        match sums.finish_guarded(CONDITION)? {
            Some(factor) => Ok(factor),
            None => self.linearise(Some(columns)),
        }
    }

    /// Over the kept columns on the way, where half the digits do: from sums of products, as long as these hold them.
    pub(super) fn passing(&mut self, kept: &[usize]) -> Result<Factor, IdentifyError> {
        if self.sums_hold {
            let (model, data, visits, at) = (self.model, self.data, self.visits, &*self.coefficients);
            let sums = gram(model, data, visits, self.noise, at, Some(kept))?;
            if let Some(factor) = sums.finish_guarded(CONDITION)? {
                return Ok(factor);
            }
            self.sums_hold = false;
        }
        self.linearise(Some(kept))
    }

    /// Residuals, and the sum of their whitened squares.
    pub(super) fn misfit(&self) -> Result<(Residuals, f64), IdentifyError> {
        misfit(self.model, self.data, self.visits, self.noise, &self.coefficients)
    }

    /// The factor with `r + A c` on its right-hand side instead of `r`; over the kept columns, β for c.
    pub(super) fn absolute(&self, reduction: &Reduction, factor: &Factor) -> Factor {
        let mut absolute = factor.clone();
        let shift = &factor.r * DVector::from_vec(reduction.grouped(&self.coefficients));
        absolute.z.column_mut(0).zip_apply(&shift, |z, s| *z += s);
        absolute
    }

    /// What the unknowns leave to scatter: as it was with nearly this noise, or anew.
    pub(super) fn freedom(
        &mut self,
        reduction: &Reduction,
        factor: &Factor,
    ) -> Result<Freedom, IdentifyError> {
        /// Changes of the noise that move traces by a trifle.
        const NEARLY: f64 = 0.02;
        let rank = reduction.rank();
        if let Some((noise, of, freedom)) = &self.freedom
            && *of == rank
            && alike(noise, &self.noise, NEARLY)
        {
            return Ok(*freedom);
        }
        let (model, data, visits, coefficients) = (self.model, self.data, self.visits, &*self.coefficients);
        let taken = Taken { model, data, visits, noise: self.noise, coefficients, kept: &reduction.kept };
        let freedom = taken.left(factor, &self.prior)?;
        self.freedom = Some((self.noise, rank, freedom));
        Ok(freedom)
    }

    /// The prior as the data now has it; whether it stayed.
    pub(super) fn look_at_prior(
        &mut self,
        reduction: &Reduction,
        factor: &Factor,
    ) -> Result<bool, IdentifyError> {
        let before = self.prior.clone();
        self.prior = self.prior.from_evidence(factor)?;
        if self.options.prior == PriorStrength::VarianceGroups {
            let beta = reduction.grouped(&self.coefficients);
            if let Some(prior) = self.prior.by_variance_groups(self.model, reduction, factor, &beta) {
                self.prior = prior;
            }
        }
        let same = |a: f64, b: f64| (a / b).ln().abs() < 1e-2;
        let widths = self.prior.widths.iter().zip(&before.widths);
        Ok(same(self.prior.kappa, before.kappa) && widths.into_iter().all(|(a, b)| same(*a, *b)))
    }

    /// Squares of the prior, unless the solver has an objective of its own.
    pub(super) fn penalty(&self, reduction: &Reduction) -> f64 {
        if self.solver.supports(Need::Outliers) {
            return 0.0;
        }
        self.prior.penalty(&reduction.grouped(&self.coefficients))
    }

    /// What another look at the structure may spoil: prior, coefficients and noise.
    pub(in crate::fit) fn spoilable(&self) -> (Prior, Vec<f64>, NoiseModel) {
        (self.prior.clone(), self.coefficients.clone(), self.noise)
    }

    /// As it was then.
    pub(in crate::fit) fn back_to(&mut self, then: (Prior, Vec<f64>, NoiseModel)) {
        (self.prior, self.coefficients, self.noise) = then;
    }
}

/// Whitened squares at the point of linearisation.
pub(super) fn squares_of(factor: &Factor) -> f64 {
    factor.z.column(0).norm_squared() + factor.rss[0]
}

/// Whether two noises are the same but for this share.
pub(super) fn alike(old: &NoiseModel, new: &NoiseModel, share: f64) -> bool {
    let close = |a: f64, b: f64| (a - b).abs() <= 0.5 * share * (a.abs() + b.abs()) + 1e-13;
    close(old.position_sd, new.position_sd)
        && close(old.visit_sd, new.visit_sd)
        && close(old.orientation_sd, new.orientation_sd)
}
