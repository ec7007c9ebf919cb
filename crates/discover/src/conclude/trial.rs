//! What the training rows and the held-out rows would have been left with, had some finds not been made, or another been made in place
//! of one of them.

use crate::conclude::linear::Linear;
use crate::conclude::whole::Whole;
use crate::data::payload::with_loads;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, Change};
use crate::model::current::{Ground, Working};
use crate::problem::linearisation::Scene;
use truepose_identify::{Fit, FitOptions, NoiseSource, Residuals};

/// (training, held out) 3-D RMS, m.
type Rms = (f64, f64);

/// The final model, ready to be asked.
pub(crate) struct Trial<'a> {
    ground: &'a Ground<'a>,
    now: &'a Working,
    found: &'a [Candidate],
    scene: &'a Scene<'a>,
    whole: &'a Whole<'a>,
    linear: Linear<'a>,
}

impl<'a> Trial<'a> {
    /// `scene` is that of all rows under the final fit.
    pub fn new(
        ground: &'a Ground<'a>,
        now: &'a Working,
        found: &'a [Candidate],
        scene: &'a Scene<'a>,
        whole: &'a Whole<'a>,
    ) -> Self {
        let mut usable = vec![false; whole.data.len()];
        whole.train_rows.iter().for_each(|&row| usable[row] = true);
        now.outliers.suspects.iter().for_each(|&row| usable[whole.train_rows[row]] = false);
        Trial { ground, now, found, scene, whole, linear: Linear::new(scene, &usable) }
    }

    /// With the first finds only.
    pub fn first(&self, count: usize) -> Result<Rms, DiscoverError> {
        self.ask(count..self.found.len(), None)
    }

    /// With another candidate in place of a find.
    pub fn instead(&self, which: usize, candidate: &Candidate) -> Result<Rms, DiscoverError> {
        self.ask(which..which + 1, Some(candidate))
    }

    /// The fit of all these rows with another candidate in place of a find.
    pub fn fit_instead(
        &self,
        which: usize,
        candidate: &Candidate,
        out: &[usize],
    ) -> Result<(Fit, Vec<Candidate>), DiscoverError> {
        let mut found = self.found.to_vec();
        found[which] = candidate.clone();
        let noise = NoiseSource::Fixed(self.now.fit.noise);
        let options = FitOptions { noise, ..self.ground.fit.clone() };
        let mut data = with_loads(self.whole.data, &found);
        for &row in out {
            data.position[row] = [f64::NAN; 3];
            data.orientation[row] = None;
        }
        Ok((self.ground.fitted_by(&found, &data, &options)?, found))
    }

    fn ask(&self, without: std::ops::Range<usize>, with: Option<&Candidate>) -> Result<Rms, DiscoverError> {
        // A corrected load is in the data, and where columns stand for others the model has to be reduced anew.
        let linear = without.clone().all(|k| {
            matches!(self.found[k].change, Change::Add(_))
                && !self.scene.entangled(self.ground.effects_of(self.found, k))
        });
        if !linear {
            return self.fitted(without, with);
        }
        let effects: Vec<_> = without.map(|k| self.ground.effects_of(self.found, k)).collect();
        let left = self.linear.left(&effects, with)?;
        let rms = |rows: &[usize]| {
            let seen = rows.iter().map(|&row| left[row]).filter(|v| v.is_finite());
            let (sum, count) = seen.fold((0.0, 0usize), |(sum, count), v| (sum + v, count + 1));
            (sum / count.max(1) as f64).sqrt()
        };
        Ok((rms(&self.whole.train_rows), rms(&self.whole.holdout_rows)))
    }

    fn fitted(
        &self,
        without: std::ops::Range<usize>,
        with: Option<&Candidate>,
    ) -> Result<Rms, DiscoverError> {
        /// Enough for the tenths of a percent of an RMS.
        const ROUNDS: usize = 6;
        let noise = NoiseSource::Fixed(self.now.fit.noise);
        let options = FitOptions { noise, max_iterations: ROUNDS, ..self.ground.fit.clone() };
        let mut found = self.found.to_vec();
        found.splice(without, with.cloned());
        let data = self.ground.prepared(&found, &self.now.outliers.suspects);
        let fit = self.ground.fitted_by(&found, &data, &options)?;
        let rms = |rows: &[usize]| -> Result<f64, DiscoverError> {
            let part = with_loads(&self.whole.data.select(rows), &found);
            Ok(Residuals::of(&fit.fitted, &part)?.positions().rms)
        };
        Ok((rms(&self.whole.train_rows)?, rms(&self.whole.holdout_rows)?))
    }
}
