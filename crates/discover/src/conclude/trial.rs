//! Errors on training rows and test set without some findings, or with a competing hypothesis in place of
//! one.

use crate::conclude::partition::Partition;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::model::current::{Context, ModelFit};
use crate::model::prepared::with_found;
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
    splits: Vec<TrialSplit<'a>>,
}

/// One partition of the rows, with the linearised fit of its first part.
struct TrialSplit<'a> {
    fitted: Vec<usize>,
    judged: Vec<usize>,
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
    ) -> Result<Self, DiscoverError> {
        let suspects = current.outliers.suspects.iter().map(|&row| partition.train_rows[row]);
        let mut good = vec![true; partition.data.len()];
        suspects.for_each(|row| good[row] = false);
        let split = |(fitted, judged): (Vec<usize>, Vec<usize>)| {
            let mut usable = vec![false; partition.data.len()];
            fitted.iter().filter(|&&row| good[row]).for_each(|&row| usable[row] = true);
            TrialSplit { linear: Linear::new(linearisation, &usable), fitted, judged }
        };
        let splits = partition.splits(context.budget().refit_folds, context.options.seed)?;
        let splits = splits.into_iter().map(split).collect();
        Ok(Trial { context, current, found, linearisation, partition, splits })
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
        let mut data = with_found(self.partition.data, &found);
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
        let mut sums = [Sum::default(); 2];
        for split in &self.splits {
            let left = split.linear.left(&effects, with)?;
            for (sum, rows) in sums.iter_mut().zip([&split.fitted, &split.judged]) {
                rows.iter().for_each(|&row| sum.add(left[row]));
            }
        }
        Ok((sums[0].rms(), sums[1].rms()))
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
        let all = with_found(self.partition.data, &found);
        let prepared = self.context.prepared(&found, &self.current.outliers.suspects);
        let mut sums = [Sum::default(); 2];
        for TrialSplit { fitted, judged, .. } in &self.splits {
            // Rows of the fit, as numbers in the searched rows.
            let searched: Vec<usize> =
                fitted.iter().filter_map(|row| self.partition.train_rows.binary_search(row).ok()).collect();
            let fit = self.context.fitted_by(&found, &prepared.select(&searched), &options)?;
            for (sum, rows) in sums.iter_mut().zip([fitted, judged]) {
                let residuals = Residuals::of(&fit.fitted, &all.select(rows))?;
                (0..rows.len()).filter_map(|k| residuals.distance(k)).for_each(|d| sum.add(d * d));
            }
        }
        Ok((sums[0].rms(), sums[1].rms()))
    }
}

/// Mean of squares that are known.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    squares: f64,
    count: usize,
}

impl Sum {
    fn add(&mut self, square: f64) {
        if square.is_finite() {
            self.squares += square;
            self.count += 1;
        }
    }

    fn rms(self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }
}
