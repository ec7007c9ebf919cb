//! Errors on training rows and test set without some findings, or with a competing hypothesis in place of
//! one.

use crate::conclude::partition::Partition;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::model::current::{Context, ModelFit};
use crate::model::prepared::with_loads;
use crate::problem::linear::Linear;
use crate::problem::linearisation::Linearisation;
use truepose_identify::{Fit, FitOptions, NoiseSource, Residuals};

/// (training, held out) 3-D RMS, m.
type Rms = (f64, f64);

/// The final model with its linearisation.
pub(crate) struct Trial<'a> {
    context: &'a Context<'a>,
    current: &'a ModelFit,
    found: &'a [Candidate],
    linearisation: &'a Linearisation<'a>,
    partition: &'a Partition<'a>,
    linear: Linear<'a>,
}

impl<'a> Trial<'a> {
    /// `linearisation` is that of all rows at the final fit.
    pub fn new(
        context: &'a Context<'a>,
        current: &'a ModelFit,
        found: &'a [Candidate],
        linearisation: &'a Linearisation<'a>,
        partition: &'a Partition<'a>,
    ) -> Self {
        let mut usable = vec![false; partition.data.len()];
        partition.train_rows.iter().for_each(|&row| usable[row] = true);
        current.outliers.suspects.iter().for_each(|&row| usable[partition.train_rows[row]] = false);
        Trial {
            context,
            current,
            found,
            linearisation,
            partition,
            linear: Linear::new(linearisation, &usable),
        }
    }

    /// With the first `count` findings only.
    pub fn first(&self, count: usize) -> Result<Rms, DiscoverError> {
        self.evaluate(count..self.found.len(), None)
    }

    /// With another candidate in place of finding `which`.
    pub fn instead(&self, which: usize, candidate: &Candidate) -> Result<Rms, DiscoverError> {
        self.evaluate(which..which + 1, Some(candidate))
    }

    /// The fit of all rows except `out` with another candidate in place of finding `which`, and its
    /// candidates.
    pub fn fit_instead(
        &self,
        which: usize,
        candidate: &Candidate,
        out: &[usize],
    ) -> Result<(Fit, Vec<Candidate>), DiscoverError> {
        let mut found = self.found.to_vec();
        found[which] = candidate.clone();
        let noise = NoiseSource::Fixed(self.current.fit.noise);
        let options = FitOptions { noise, ..self.context.fit.clone() };
        let mut data = with_loads(self.partition.data, &found);
        for &row in out {
            data.position[row] = [f64::NAN; 3];
            data.orientation[row] = None;
        }
        Ok((self.context.fitted_by(&found, &data, &options)?, found))
    }

    fn evaluate(
        &self,
        without: std::ops::Range<usize>,
        with: Option<&Candidate>,
    ) -> Result<Rms, DiscoverError> {
        // A corrected payload is part of the data, and where a column represents dropped columns the model
        // has to be reduced again: both need a fit.
        let linear = without.clone().all(|k| {
            matches!(self.found[k].change, Change::Add(_))
                && !self.linearisation.entangled(self.context.effects_of(self.found, k))
        });
        if !linear {
            return self.fitted(without, with);
        }
        let effects: Vec<_> = without.map(|k| self.context.effects_of(self.found, k)).collect();
        let left = self.linear.left(&effects, with)?;
        let rms = |rows: &[usize]| {
            let seen = rows.iter().map(|&row| left[row]).filter(|v| v.is_finite());
            let (sum, count) = seen.fold((0.0, 0usize), |(sum, count), v| (sum + v, count + 1));
            (sum / count.max(1) as f64).sqrt()
        };
        Ok((rms(&self.partition.train_rows), rms(&self.partition.holdout_rows)))
    }

    fn fitted(
        &self,
        without: std::ops::Range<usize>,
        with: Option<&Candidate>,
    ) -> Result<Rms, DiscoverError> {
        let noise = NoiseSource::Fixed(self.current.fit.noise);
        let options = FitOptions {
            noise,
            max_iterations: self.context.budget().trial_iterations,
            ..self.context.fit.clone()
        };
        let mut found = self.found.to_vec();
        found.splice(without, with.cloned());
        let data = self.context.prepared(&found, &self.current.outliers.suspects);
        let fit = self.context.fitted_by(&found, &data, &options)?;
        let rms = |rows: &[usize]| -> Result<f64, DiscoverError> {
            let part = with_loads(&self.partition.data.select(rows), &found);
            Ok(Residuals::of(&fit.fitted, &part)?.positions().rms)
        };
        Ok((rms(&self.partition.train_rows)?, rms(&self.partition.holdout_rows)?))
    }
}
