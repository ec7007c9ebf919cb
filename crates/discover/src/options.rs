//! How to look.

use crate::error::DiscoverError;
use crate::hypotheses::family::Family;
use truepose_identify::{FitOptions, PriorStrength};

/// Sign flips beyond this many say nothing that fewer do not, and have to be kept in memory.
const MOST_FLIPS: usize = 1_000_000;

/// How a discovery looks, and when it believes.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscoverOptions {
    /// Share of the configurations that is drawn first and takes part in nothing.
    pub holdout: f64,
    /// Seed of every draw.
    pub seed: u64,
    /// Sign flips B.
    pub flips: usize,
    /// Family-wise probability above which a find is chance.
    pub alpha: f64,
    /// Effects at most.
    pub most: usize,
    /// Families that are not looked for: to see what the loop makes of a cause that it has no word for. Outliers are always
    /// looked for, since they stand in the way of everything else.
    pub without: Vec<Family>,
    /// Whether explanations that the data cannot tell from a find are fitted as well: what a plan needs that is to tell them apart.
    pub rival_fits: bool,
    /// How models are fitted.
    pub fit: FitOptions,
}

/// A search does not wait for the last digits of a curved valley: units of χ² below which a round gains nothing. A candidate that is worth its
/// place gains thousands of times as much.
const FLAT: f64 = 1e-2;

impl Default for DiscoverOptions {
    fn default() -> Self {
        DiscoverOptions {
            holdout: 0.2,
            seed: 0,
            flips: 999,
            alpha: 0.002,
            most: 24,
            without: Vec::new(),
            rival_fits: false,
            fit: FitOptions { flat: FLAT, prior: PriorStrength::VarianceGroups, ..FitOptions::default() },
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
