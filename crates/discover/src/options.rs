//! Options of a discovery.

use crate::budget::Budget;
use crate::error::DiscoverError;
use crate::hypotheses::library::Library;
use crate::policy::Policy;
use truepose_identify::{FitOptions, PriorStrength};

/// Largest number of sign flips: they are kept in memory, and a resolution of p finer than 1e-6 has no use.
const MOST_FLIPS: usize = 1_000_000;

/// Options of a discovery.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscoverOptions {
    /// Fraction of the configurations in the held-out test set; above 0, at most 0.5.
    pub holdout: f64,
    /// Seed of all random draws: test set, sample, folds, half-samples, sign flips.
    pub seed: u64,
    /// Number of sign flips B; 1/(B + 1) has to be at most `alpha`.
    pub flips: usize,
    /// Level α of the family-wise test of each screen.
    pub alpha: f64,
    /// Largest number of findings.
    pub most: usize,
    /// The hypotheses that are tested. Outliers are always excluded, since they bias every fit.
    pub library: Library,
    /// Whether competing hypotheses that are not distinguishable from a finding are fitted as well, for a
    /// measurement plan that distinguishes them.
    pub competing_fits: bool,
    /// Options of the fits.
    pub fit: FitOptions,
    /// What is believed before the data is seen.
    pub policy: Policy,
    /// How much work is spent.
    pub budget: Budget,
}

/// Decrease of χ² per iteration below which a fit of the search has converged. The penalty of one
/// coefficient, ln m > 3, is three hundred times as much.
const FLAT: f64 = 1e-2;

impl Default for DiscoverOptions {
    fn default() -> Self {
        DiscoverOptions {
            holdout: 0.2,
            seed: 0,
            flips: 999,
            alpha: 0.002,
            most: 24,
            library: Library::standard(),
            competing_fits: false,
            fit: FitOptions { flat: FLAT, prior: PriorStrength::VarianceGroups, ..FitOptions::default() },
            policy: Policy::default(),
            budget: Budget::default(),
        }
    }
}

impl DiscoverOptions {
    /// Checks the ranges.
    ///
    /// # Errors
    /// Names the option that is out of its range.
    pub fn validate(&self) -> Result<(), DiscoverError> {
        let refuse = |option, value, expected| Err(DiscoverError::Option { option, value, expected });
        if !(self.holdout > 0.0 && self.holdout <= 0.5) {
            return refuse("holdout", self.holdout, "above 0 and at most 0.5");
        }
        if !(self.alpha > 0.0 && self.alpha < 1.0) {
            return refuse("alpha", self.alpha, "between 0 and 1");
        }
        if self.flips < 19 {
            return refuse("flips", self.flips as f64, "at least 19");
        }
        if self.flips > MOST_FLIPS {
            return refuse("flips", self.flips as f64, "at most 1 000 000");
        }
        if ((self.flips + 1) as f64).recip() > self.alpha {
            return refuse("flips", self.flips as f64, "so many that 1/(flips + 1) is below alpha");
        }
        Ok(self.fit.validate()?)
    }
}
