//! The rounds of a fit: solve, move, look at the noise and the prior, until nothing moves.

mod finish;
mod second_look;
mod solve;
mod whole;

pub(crate) use whole::from_factor;

use super::{FitOptions, NoiseSource};
use crate::freedom::Taken;
use crate::linearise::{factorise, gram, misfit};
use crate::reduction::Reduction;
use crate::{Freedom, IdentifyError, NoiseModel, Prior, PriorStrength, Residuals, estimate_noise};
use nalgebra::DVector;
use truepose_errormodel::{Dataset, ErrorModel, Visits};
use truepose_solvers::accumulator::Factor;
use truepose_solvers::{Need, Solution, SolveError, Solver};

/// Everything that a fit has while it runs.
pub(super) struct State<'a> {
    model: &'a ErrorModel,
    data: &'a Dataset,
    visits: &'a Visits,
    solver: &'a dyn Solver,
    pub(super) options: FitOptions,
    observations: usize,
    noise: NoiseModel,
    pub(super) prior: Prior,
    pub(super) coefficients: Vec<f64>,
    /// Whether sums of products have held the digits of every factor so far.
    sums_hold: bool,
    /// What the unknowns leave to scatter, with the noise and the number of unknowns at which that was asked.
    freedom: Option<(NoiseModel, usize, Freedom)>,
}

/// How the rounds ended.
pub(super) struct Outcome {
    solution: Solution,
    rounds: usize,
    converged: bool,
    /// At the last coefficients, over the kept columns.
    factor: Factor,
    /// At the last coefficients.
    residuals: Residuals,
}

impl<'a> State<'a> {
    pub(super) fn new(
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
            sums_hold: true,
            freedom: None,
        })
    }

    /// Over all columns, or over these.
    pub(super) fn linearise(&self, columns: Option<&[usize]>) -> Result<Factor, IdentifyError> {
        factorise(self.model, self.data, self.visits, self.noise, &self.coefficients, columns)
    }

    /// Over the kept columns on the way, where half the digits do: from sums of products, as long as these hold them.
    fn passing(&mut self, kept: &[usize]) -> Result<Factor, IdentifyError> {
        /// Condition number of the columns, brought to length one.
        const MOST: f64 = 1e5;
        if self.sums_hold {
            let (model, data, visits, at) = (self.model, self.data, self.visits, &*self.coefficients);
            let sums = gram(model, data, visits, self.noise, at, Some(kept))?;
            if let Some(factor) = sums.finish_guarded(MOST)? {
                return Ok(factor);
            }
            self.sums_hold = false;
        }
        self.linearise(Some(kept))
    }

    /// Residuals, and the sum of their whitened squares.
    fn misfit(&self) -> Result<(Residuals, f64), IdentifyError> {
        misfit(self.model, self.data, self.visits, self.noise, &self.coefficients)
    }

    /// The factor with `r + A c` on its right-hand side instead of `r`; over the kept columns, β for c.
    fn absolute(&self, reduction: &Reduction, factor: &Factor) -> Factor {
        let mut absolute = factor.clone();
        let shift = &factor.r * DVector::from_vec(reduction.grouped(&self.coefficients));
        absolute.z.column_mut(0).zip_apply(&shift, |z, s| *z += s);
        absolute
    }

    /// Gauss–Newton rounds, with the noise estimated between them.
    pub(super) fn rounds(&mut self, reduction: &Reduction, first: Factor) -> Result<Outcome, IdentifyError> {
        /// Steps (in standard deviations, relative) below which nothing moves, and below which the noise is looked at.
        const STILL: f64 = 1e-8;
        const FIRST_LOOK: f64 = 0.1;
        const NEAR: f64 = 1e-4;
        const MOST_LOOKS: usize = 15;
        const FIRST_DAMPING: f64 = 1e-4;
        const WORSE: f64 = 1e-6;
        const MOST_FLAT: usize = 3;
        const MOST_UNGUARDED: usize = 20;
        // A penalty that only the solver knows, or weights that it changes, make no objective to hold steps against.
        let guarded = self.options.refine
            && self.solver.supports(Need::Unpenalised)
            && !self.solver.supports(Need::Outliers);
        let scales: Vec<f64> = reduction.kept.iter().map(|&c| self.model.columns()[c].scale).collect();
        let limit = match (self.options.refine, guarded) {
            (false, _) => 1,
            (true, true) => self.options.max_rounds,
            (true, false) => self.options.max_rounds.min(MOST_UNGUARDED),
        };
        // Noise and prior are looked at when steps have become short, the more often the less they still change.
        let mut near = FIRST_LOOK;
        let mut factor = first;
        let mut damping = 0.0;
        let (mut flat, mut looks) = (0, 0);
        let mut rounds = 0;
        loop {
            rounds += 1;
            let before = squares_of(&factor) + self.penalty(reduction);
            let (solution, target) = self.solve(reduction, &factor, &scales, damping)?;
            let mut moved = self.step(reduction, &factor, &target);
            let start = std::mem::replace(&mut self.coefficients, target);
            // Where the noise will be looked at, and where a step may well be taken back, residuals come first; elsewhere the new
            // factor says what is left.
            let last = rounds >= limit;
            let look = moved < near || last || flat + 1 >= MOST_FLAT;
            let (residuals, next, squares) = if look || damping > 0.0 {
                let (residuals, squares) = self.misfit()?;
                (Some(residuals), None, squares)
            } else {
                match self.passing(&reduction.kept) {
                    Ok(next) => {
                        let squares = squares_of(&next);
                        (None, Some(next), squares)
                    }
                    // Beyond all numbers, not merely too far.
                    Err(IdentifyError::Solve(SolveError::NotFinite { .. })) if guarded => {
                        (None, None, f64::INFINITY)
                    }
                    Err(error) => return Err(error),
                }
            };
            let squares = if squares.is_nan() { f64::INFINITY } else { squares };
            let after = squares + self.penalty(reduction);
            if guarded && moved > STILL && after > before * (1.0 + WORSE) && rounds < limit {
                // Too far for the linear picture: the same point again, with a shorter step. Weights follow the posture
                // from round to round only, so that the last steps may lose a trifle.
                self.coefficients = start;
                damping = (10.0 * damping).max(FIRST_DAMPING);
                continue;
            }
            damping = if damping > FIRST_DAMPING { 0.2 * damping } else { 0.0 };
            // In a flat valley steps stay long while nothing is gained any more: that is the end, too.
            flat = if guarded && before - after < self.options.flat * before { flat + 1 } else { 0 };
            if flat >= MOST_FLAT {
                moved = 0.0;
            }
            let Some(residuals) = residuals.filter(|_| look) else {
                factor = match next {
                    Some(next) => next,
                    None => self.passing(&reduction.kept)?,
                };
                continue;
            };
            near = NEAR.min(near);
            looks += 1;
            let mut settled = true;
            if self.options.noise == NoiseSource::Estimate {
                let freedom = self.freedom(reduction, &factor)?;
                let noise = estimate_noise(self.data, self.visits, &residuals, &freedom);
                settled &= alike(&self.noise, &noise, 2e-3);
                self.noise = noise;
            }
            factor =
                if last { self.linearise(Some(&reduction.kept))? } else { self.passing(&reduction.kept)? };
            if self.options.prior.asks_the_data() {
                settled &= self.look_at_prior(reduction, &self.absolute(reduction, &factor))?;
            }
            if settled || looks > MOST_LOOKS {
                settled = true;
                near = STILL;
            }
            if (settled && moved < STILL) || last {
                let converged = moved < STILL || !self.options.refine;
                let passed = self.sums_hold && !last;
                let factor = if passed { self.linearise(Some(&reduction.kept))? } else { factor };
                return Ok(Outcome { solution, rounds, converged, factor, residuals });
            }
        }
    }

    /// What the unknowns leave to scatter: as it was with nearly this noise, or anew.
    fn freedom(&mut self, reduction: &Reduction, factor: &Factor) -> Result<Freedom, IdentifyError> {
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
    fn look_at_prior(&mut self, reduction: &Reduction, factor: &Factor) -> Result<bool, IdentifyError> {
        let before = self.prior.clone();
        self.prior = self.prior.from_evidence(factor)?;
        if self.options.prior == PriorStrength::Kinds {
            let beta = reduction.grouped(&self.coefficients);
            if let Some(prior) = self.prior.by_kinds(self.model, reduction, factor, &beta) {
                self.prior = prior;
            }
        }
        let same = |a: f64, b: f64| (a / b).ln().abs() < 1e-2;
        let widths = self.prior.widths.iter().zip(&before.widths);
        Ok(same(self.prior.kappa, before.kappa) && widths.into_iter().all(|(a, b)| same(*a, *b)))
    }

    /// Squares of the prior, unless the solver has an objective of its own.
    fn penalty(&self, reduction: &Reduction) -> f64 {
        if self.solver.supports(Need::Outliers) {
            return 0.0;
        }
        self.prior.penalty(&reduction.grouped(&self.coefficients))
    }
}

/// Whitened squares at the point of linearisation.
fn squares_of(factor: &Factor) -> f64 {
    factor.z.column(0).norm_squared() + factor.rss[0]
}

/// Whether two noises are the same but for this share.
fn alike(old: &NoiseModel, new: &NoiseModel, share: f64) -> bool {
    let close = |a: f64, b: f64| (a - b).abs() <= 0.5 * share * (a.abs() + b.abs()) + 1e-13;
    close(old.position_sd, new.position_sd)
        && close(old.visit_sd, new.visit_sd)
        && close(old.orientation_sd, new.orientation_sd)
}
