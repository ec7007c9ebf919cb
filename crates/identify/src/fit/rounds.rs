//! The rounds of a fit: solve, move, look at the noise and the prior, until nothing moves.

mod finish;
mod first_look;
mod follow;
mod second_look;
mod settle;
mod solve;
mod trust;
mod whole;

pub(super) use follow::doubted;
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
use trust::{Promise, Trust};

/// Condition number of the columns, brought to length one, up to which sums of products hold half the digits.
const CONDITION: f64 = 1e5;
/// Relative step below which nothing moves.
const STILL: f64 = 1e-8;
/// Share of its standard deviation by which no unknown moves any more.
const STILL_DEVIATIONS: f64 = 1e-3;
/// What the objective may rise by in a step: weights follow the posture from round to round only. As a share, and in units.
const WORSE: f64 = 1e-6;
const TRIFLE: f64 = 1e-3;
/// A step that keeps less than this share of its promise may have to be bent.
const FAIR: f64 = 0.5;
/// So many rounds in turn without gain end the fit: where none moves by much, and wherever it stands.
const MOST_IDLE: usize = 12;
const MOST_FLAT: usize = 3;

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
    /// Whether the data has not yet been asked for the noise and the prior.
    pub(super) unseen: bool,
    /// Whether sums of products have held the digits of every factor so far.
    sums_hold: bool,
    /// What the unknowns leave to scatter, with the noise and the number of unknowns at which that was asked.
    freedom: Option<(NoiseModel, usize, Freedom)>,
}

/// How the rounds ended.
pub(super) struct Outcome {
    solution: Solution,
    pub(super) rounds: usize,
    converged: bool,
    /// At the last coefficients, over the kept columns.
    factor: Factor,
    /// At the last coefficients.
    residuals: Residuals,
}

impl Outcome {
    /// Whether the last round moved nothing any more.
    pub(super) fn converged(&self) -> bool {
        self.converged
    }
}

impl<'a> State<'a> {
    /// The model.
    pub(super) fn fitted_model(&self) -> &'a ErrorModel {
        self.model
    }

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
            unseen: true,
            sums_hold: true,
            freedom: None,
        })
    }

    /// Over all columns, or over these.
    pub(super) fn linearise(&self, columns: Option<&[usize]>) -> Result<Factor, IdentifyError> {
        factorise(self.model, self.data, self.visits, self.noise, &self.coefficients, columns)
    }

    /// Over these columns on the way, for a correction of a step.
    fn passing_over(&self, columns: &[usize]) -> Result<Factor, IdentifyError> {
        let (model, data, visits, at) = (self.model, self.data, self.visits, &*self.coefficients);
        let sums = gram(model, data, visits, self.noise, at, Some(columns))?;
        match sums.finish_guarded(CONDITION)? {
            Some(factor) => Ok(factor),
            None => self.linearise(Some(columns)),
        }
    }

    /// Over the kept columns on the way, where half the digits do: from sums of products, as long as these hold them.
    fn passing(&mut self, kept: &[usize]) -> Result<Factor, IdentifyError> {
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

    /// Gauss–Newton rounds within a region of trust, with the noise estimated between them.
    pub(super) fn rounds(&mut self, reduction: &Reduction, first: Factor) -> Result<Outcome, IdentifyError> {
        /// Steps below which the noise is looked at: first, relative to all that is explained; then in standard deviations.
        const FIRST_LOOK: f64 = 0.1;
        const NEAR: f64 = 0.1;
        const MOST_LOOKS: usize = 15;
        // A penalty that only the solver knows, or weights that it changes, make no objective to hold steps against.
        let guarded = self.options.refine && super::guarded(self.solver);
        let scales: Vec<f64> = reduction.kept.iter().map(|&c| self.model.columns()[c].scale).collect();
        let mut limit = if self.options.refine { self.options.max_rounds } else { 1 };
        // Noise and prior are looked at when steps have become short.
        let mut settled = false;
        let mut factor = self.first_look(reduction, first)?;
        let mut trust = Trust::default();
        let placement = self.placement(reduction);
        let (mut flat, mut idle, mut looks) = (0, 0, 0);
        let (mut stalled, mut rounds) = (false, 0);
        loop {
            rounds += 1;
            let before = squares_of(&factor) + self.penalty(reduction);
            let damping = if guarded { self.damping(reduction, &factor, trust.radius) } else { 0.0 };
            let (solution, target) = self.solve(reduction, &factor, &scales, damping)?;
            let moved = self.step(reduction, &factor, &target);
            let promise = self.promise(reduction, &factor, &target);
            let start = std::mem::replace(&mut self.coefficients, target);
            // Where the noise will be looked at, and where a step may well be taken back, residuals come first; elsewhere the new
            // factor says what is left.
            let last = rounds >= limit;
            let free = damping <= 0.0;
            let near = match (settled, looks) {
                (true, _) => still(moved, &promise),
                (false, 0) => moved < FIRST_LOOK || promise.deviations < NEAR,
                (false, _) => moved < STILL || promise.deviations < NEAR,
            };
            let look = (free && near) || last || flat + 1 >= MOST_FLAT;
            let (mut residuals, mut next, squares) = if look || damping > 0.0 {
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
            let mut after = squares + self.penalty(reduction);
            if guarded
                && moved > STILL
                && before - after < FAIR * promise.gain
                && promise.gain > TRIFLE
                && !placement.is_empty()
            {
                let straight = self.coefficients.clone();
                self.settle(reduction, &placement)?;
                let (left, squares) = self.misfit()?;
                let settled = squares + self.penalty(reduction);
                if settled < after {
                    (residuals, next, after) = (Some(left), None, settled);
                } else {
                    self.coefficients = straight;
                }
            }
            let small = free && promise.deviations < NEAR;
            if guarded {
                // Weights follow the posture from round to round only, so that the last steps may lose a trifle.
                let slack = (WORSE * before).max(if small { NEAR * NEAR } else { TRIFLE });
                let worse = after > before + slack;
                idle = if before - after < self.options.flat { idle + 1 } else { 0 };
                if idle >= MOST_IDLE && rounds < limit {
                    // Neither far nor near can anything be gained: one more round, of a whole step, to say how it stands.
                    limit = rounds + 1;
                    (stalled, trust.radius) = (true, f64::INFINITY);
                }
                if worse {
                    // Too far for the linear picture: the same point again, with a shorter step.
                    self.coefficients = start;
                    if !stalled {
                        trust.after(promise.length, (before - after) / promise.gain.max(f64::MIN_POSITIVE));
                    }
                    if rounds < limit {
                        continue;
                    }
                    residuals = Some(self.misfit()?.0);
                } else {
                    let kept = if promise.gain > slack { (before - after) / promise.gain } else { 1.0 };
                    trust.after(promise.length, kept);
                }
            }
            // Where nothing is gained any more and no unknown moves by a tenth of its standard deviation, it is the end, too.
            flat = if guarded && small && (before - after).abs() < self.options.flat { flat + 1 } else { 0 };
            // How compliances change with the coefficients is left out of the slope: at the least of the objective a step may be left over.
            let stands = free && (still(moved, &promise) || flat >= MOST_FLAT || (stalled && small));
            let Some(residuals) = residuals.filter(|_| look) else {
                factor = match next {
                    Some(next) => next,
                    None => self.passing(&reduction.kept)?,
                };
                continue;
            };
            looks += 1;
            settled = true;
            if self.options.noise == NoiseSource::Estimate {
                let freedom = self.freedom(reduction, &factor)?;
                let noise = estimate_noise(self.data, self.visits, &residuals, &freedom);
                settled &= alike(&self.noise, &noise, 2e-3);
                self.noise = noise;
            }
            factor =
                if last { self.linearise(Some(&reduction.kept))? } else { self.passing(&reduction.kept)? };
            // The prior of a single step is the one that it was taken with.
            if self.options.prior.asks_the_data() && self.options.refine {
                settled &= self.look_at_prior(reduction, &self.absolute(reduction, &factor))?;
            }
            settled |= looks > MOST_LOOKS;
            if (settled && stands) || last {
                let converged = stands || !self.options.refine;
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

/// Whether a step moves nothing: relative to all that is explained, or to what is known of the unknowns.
fn still(moved: f64, promise: &Promise) -> bool {
    moved < STILL || promise.deviations < STILL_DEVIATIONS
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
