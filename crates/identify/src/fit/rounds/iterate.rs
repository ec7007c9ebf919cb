//! The rounds of a fit: solve, move, look at the noise and the prior, until nothing moves.

use super::state::{Outcome, STILL, STILL_DEVIATIONS, State, TRIFLE, WORSE, alike, squares_of};
use super::trust::{Promise, Trust};
use crate::fit::objective::guarded;
use crate::fit::options::NoiseSource;
use crate::reduction::Reduction;
use crate::{IdentifyError, estimate_noise};
use truepose_solvers::SolveError;
use truepose_solvers::accumulator::Factor;

/// A step that keeps less than this share of its promise may have to be bent.
const FAIR: f64 = 0.5;
/// So many rounds in turn without gain end the fit: where none moves by much, and wherever it stands.
const MOST_IDLE: usize = 12;
const MOST_FLAT: usize = 3;

impl State<'_> {
    /// Gauss–Newton rounds within a region of trust, with the noise estimated between them.
    pub(in crate::fit) fn rounds(
        &mut self,
        reduction: &Reduction,
        first: Factor,
    ) -> Result<Outcome, IdentifyError> {
        /// Steps below which the noise is looked at: first, relative to all that is explained; then in standard deviations.
        const FIRST_LOOK: f64 = 0.1;
        const NEAR: f64 = 0.1;
        const MOST_LOOKS: usize = 15;
        // A penalty that only the solver knows, or weights that it changes, make no objective to hold steps against.
        let guarded = self.options.refine && guarded(self.solver);
        let scales: Vec<f64> = reduction.kept.iter().map(|&c| self.model.columns()[c].scale).collect();
        let mut limit = if self.options.refine { self.options.max_iterations } else { 1 };
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
}

/// Whether a step moves nothing: relative to all that is explained, or to what is known of the unknowns.
fn still(moved: f64, promise: &Promise) -> bool {
    moved < STILL || promise.deviations < STILL_DEVIATIONS
}
