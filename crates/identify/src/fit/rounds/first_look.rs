//! Noise and prior before the first step, as the first linear picture has them.
//!
//! Both start as guesses. A guess of a tenth of a millimetre where two are left over, or of a prior thirty times too wide, lets the weak
//! directions of the first step run to where no linear picture holds, into valleys that bend; the way back takes hundreds of rounds.
//! The marginal likelihood of the first picture knows better before any step is taken.

use super::state::State;
use crate::IdentifyError;
use crate::fit::options::NoiseSource;
use crate::reduction::Reduction;
use truepose_solvers::accumulator::Factor;

impl State<'_> {
    /// Sets noise and κ; the factor as it is with them.
    pub(super) fn first_look(
        &mut self,
        reduction: &Reduction,
        mut factor: Factor,
    ) -> Result<Factor, IdentifyError> {
        if !std::mem::take(&mut self.unseen) {
            return Ok(factor);
        }
        let ask = self.options.prior.asks_the_data();
        let estimated = self.options.noise == NoiseSource::Estimate;
        // A single step without a prior is the same whatever the noise.
        let needed = ask || estimated && (self.options.refine || self.prior.kappa.is_finite());
        if !needed || factor.columns() == 0 {
            return Ok(factor);
        }
        let numbers = estimated.then_some(self.observations);
        let absolute = self.absolute(reduction, &factor);
        let (kappa, scale) = self.prior.at_first_sight(&absolute, numbers, ask)?;
        if ask {
            self.prior.kappa = kappa;
        }
        if estimated {
            let (old, s) = (self.noise, scale.max(LEAST));
            self.noise.position_sd = old.position_sd * s;
            self.noise.orientation_sd = old.orientation_sd * s;
            if self
                .data
                .position_sd
                .iter()
                .chain(&self.data.orientation_sd)
                .flatten()
                .any(|sd| sd.is_finite())
            {
                // What the instrument states is not scaled.
                return self.passing(&reduction.kept);
            }
            factor.r /= s;
            factor.z /= s;
            factor.rss.iter_mut().for_each(|rss| *rss /= s * s);
        }
        Ok(factor)
    }
}

/// No noise is scaled to less than this share of the guess: a look at the residuals decides that.
const LEAST: f64 = 1e-9;
