//! The law of quadratic forms where the scale of the noise was estimated with the fit.
//!
//! ```text
//! x/k ~ F(k, ν),    ν = 3 n − r
//! ```
//!
//! | symbol | here | |
//! | --- | --- | --- |
//! | x | rᵀ Q r, or the gain of a suspect | residuals weighed with the noise of the fit, and with its covariance, which has the same scale |
//! | k | its degrees of freedom | |
//! | n | poses of the fit where rows of a pose share the repeatability, else its rows | |
//! | r | coefficients that the fit determined | prior and data together |
//!
//! With a variance known to 10 %, as of 70 poses of one target, χ² would raise five times the alarms that are stated. A fit that holds no
//! rows of its data, as the mean of a fleet, is taken to know its noise.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};
use truepose_errormodel::{FittedModel, Visits};
use truepose_identify::student_quantile;

/// Degrees of freedom beyond which the scale counts as known.
const KNOWN: f64 = 1e5;

/// ν of a fit; none where its noise counts as known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NoiseLaw(Option<f64>);

impl NoiseLaw {
    pub fn of(fitted: &FittedModel) -> Self {
        let sample = &fitted.domain.sample;
        let rows = sample.rows().len();
        if rows == 0 {
            return NoiseLaw(None);
        }
        let drawn = sample.drawn_from().max(rows) as f64;
        let units = match fitted.repeatability_sd > 0.0 {
            true => drawn * Visits::of(sample.rows()).len() as f64 / rows as f64,
            false => drawn,
        };
        let covariance = fitted.covariance();
        let known = (0..covariance.nrows()).filter(|&k| covariance[(k, k)] > 0.0).count() as f64;
        let freedom = (3.0 * units - known).max(1.0);
        NoiseLaw(Some(freedom).filter(|freedom| *freedom < KNOWN))
    }

    /// With this share of the degrees of freedom.
    pub fn share(self, share: f64) -> Self {
        NoiseLaw(self.0.map(|freedom| (share * freedom).max(1.0)))
    }

    /// P(X ≥ x), with k degrees of freedom.
    pub fn beyond(self, x: f64, k: usize) -> f64 {
        self.beyond_of(x, k as f64)
    }

    /// The same of a number of degrees of freedom that need not be whole.
    pub fn beyond_of(self, x: f64, k: f64) -> f64 {
        match self.0 {
            Some(freedom) => FisherSnedecor::new(k, freedom).map_or(1.0, |law| law.sf(x / k)),
            None => ChiSquared::new(k).map_or(1.0, |law| law.sf(x)),
        }
    }

    /// Half width of a 95 % interval, in standard deviations.
    pub fn half(self) -> f64 {
        student_quantile(0.975, self.0.map_or(usize::MAX, |freedom| freedom.round() as usize))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimated_scale_has_longer_tails_and_a_known_one_is_chi_square() {
        let (known, many, few) = (NoiseLaw(None), NoiseLaw(Some(9e4)), NoiseLaw(Some(90.0)));
        // 5 % points of χ² with 36 degrees of freedom, and of F(36, 90): 50.998 and 1.5477.
        assert!((known.beyond(50.998, 36) - 0.05).abs() < 1e-4);
        assert!((many.beyond(50.998, 36) - 0.05).abs() < 1e-3);
        assert!((few.beyond(36.0 * 1.5477, 36) - 0.05).abs() < 2e-3, "{}", few.beyond(36.0 * 1.5477, 36));
        assert!(few.beyond(50.998, 36) > 0.08);
        // One degree of freedom is the square of Student's t.
        let t = few.half();
        assert!((few.beyond(t * t, 1) - 0.05).abs() < 1e-6);
        assert!((known.half() - 1.96).abs() < 1e-3);
    }
}
