//! How to fit.

use crate::{IdentifyError, NoiseModel, PriorStrength};
use truepose_solvers::RankRule;

/// How to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitOptions {
    /// Re-linearise until nothing moves; otherwise the paper's single linear step.
    pub refine: bool,
    /// Rounds at most.
    pub max_iterations: usize,
    /// Look at the reduction again where the rounds end, and take in what the data determines there though not at the nominal robot;
    /// otherwise what is left out at the nominal robot is left out for good, as in the paper.
    pub second_reduction: bool,
    /// Three rounds in turn that gain less than this of the objective, in units (1 is a standard deviation of one number), end the fit
    /// where no unknown moves by a tenth of its standard deviation any more: the floor of a flat valley.
    pub flat: f64,
    /// How ranks are decided.
    pub rank: RankRule,
    /// How strongly coefficients are held to their expected sizes.
    pub prior: PriorStrength,
    /// Where standard deviations come from.
    pub noise: NoiseSource,
    /// What is done about parameters in which an effect is not linear and that it leaves free.
    pub shapes: NonlinearSearch,
}

/// Where the standard deviations of the rows come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoiseSource {
    /// From the residuals, on top of what the instrument states.
    Estimate,
    /// Given.
    Fixed(NoiseModel),
}

impl Default for FitOptions {
    fn default() -> Self {
        FitOptions {
            refine: true,
            max_iterations: 500,
            second_reduction: true,
            flat: 1e-3,
            rank: RankRule::Default,
            prior: PriorStrength::VarianceGroups,
            noise: NoiseSource::Estimate,
            shapes: NonlinearSearch::default(),
        }
    }
}

impl FitOptions {
    /// Checks the ranges.
    ///
    /// # Errors
    /// Names the option that is out of its range.
    pub fn validate(&self) -> Result<(), IdentifyError> {
        self.rank.validate()?;
        if let PriorStrength::Fixed(kappa) = self.prior
            && !(kappa.is_finite() && kappa > 0.0)
        {
            return Err(IdentifyError::Option { option: "prior", value: kappa, expected: "above 0" });
        }
        if !(self.flat >= 0.0 && self.flat < 1.0) {
            return Err(IdentifyError::Option {
                option: "flat",
                value: self.flat,
                expected: "from 0 to below 1",
            });
        }
        if self.max_iterations == 0 {
            return Err(IdentifyError::Option {
                option: "max_iterations",
                value: 0.0,
                expected: "at least 1",
            });
        }
        Ok(())
    }
}

/// What is done about parameters in which an effect is not linear and that it leaves free ([`truepose_errormodel::Effect::shape`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NonlinearSearch {
    /// They are taken as they stand.
    Fixed,
    /// Coefficients are solved for at every trial of them.
    #[default]
    Profiled,
    /// They are stepped together with the coefficients; the same optimum, for comparison.
    Joint,
}
