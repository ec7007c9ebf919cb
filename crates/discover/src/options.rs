//! Options of a discovery.

use crate::budget::Budget;
use crate::error::DiscoverError;
use crate::hypotheses::library::Library;
use crate::policy::Policy;
use truepose_identify::{FitOptions, PriorStrength};

/// Fewest random rotations: their largest fifth gives the tail of the distribution.
pub(crate) const FEWEST_ROTATIONS: usize = 99;

/// Most random rotations: they are kept in memory.
const MOST_ROTATIONS: usize = 100_000;

/// Options of a discovery.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscoverOptions {
    /// Fraction of the configurations in the held-out test set, above 0 and at most 0.5. `None`: a fifth, or no test set but nested folds
    /// where that would leave fewer than [`Policy::few_poses`] poses.
    pub holdout: Option<f64>,
    /// Seed of all random draws: test set, sample, folds, half-samples, rotations.
    pub seed: u64,
    /// Number of random rotations behind each family-wise p-value, 99 to 100 000.
    pub rotations: usize,
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
            holdout: None,
            seed: 0,
            rotations: 499,
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
        if let Some(holdout) = self.holdout
            && !(holdout > 0.0 && holdout <= 0.5)
        {
            return refuse("holdout", holdout, "above 0 and at most 0.5");
        }
        if !(self.alpha > 0.0 && self.alpha < 1.0) {
            return refuse("alpha", self.alpha, "between 0 and 1");
        }
        if !(FEWEST_ROTATIONS..=MOST_ROTATIONS).contains(&self.rotations) {
            return refuse("rotations", self.rotations as f64, "99 to 100 000");
        }
        Ok(self.fit.validate()?)
    }
}
