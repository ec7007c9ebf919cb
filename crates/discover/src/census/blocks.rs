//! Rows in blocks of whole poses.

use crate::census::derived::{Derived, missing};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::problem::noise::Noise;
use rayon::prelude::*;
use std::collections::BTreeSet;
use truepose_errormodel::{AnyEffect, Dataset, Visits};
use truepose_identify::Fit;

/// Rows of a block, at most about.
const ROWS: usize = 2048;
/// Blocks that are worked on before their results are taken: no more are in memory.
const AT_ONCE: usize = 8;
/// Derived channels of all rows that are in memory for the candidates of one pass.
const CHANNELS: usize = 96;
/// Contiguous parts of the data, at most, whose scores are kept apart.
const UNITS: usize = 60;

/// Rows in blocks of whole poses, in their order.
pub(crate) struct Blocks {
    data: Dataset,
    rows: Vec<Vec<usize>>,
    /// The noise of the search where the joints scatter.
    noise: Option<Noise>,
}

impl Blocks {
    /// Of these rows.
    pub fn new(data: Dataset) -> Self {
        let size = (data.len() / UNITS).clamp(1, ROWS);
        let mut rows: Vec<Vec<usize>> = Vec::new();
        for own in Visits::of(&data).rows {
            match rows.last_mut() {
                Some(block) if block.len() < size => block.extend(own),
                _ => rows.push(own),
            }
        }
        Blocks { data: data.recorded(), rows, noise: None }
    }

    /// With the noise of a search in which the joints scatter.
    pub fn under(self, noise: Option<Noise>) -> Self {
        Blocks { noise, ..self }
    }

    /// Data linearised at a fit, under that noise, or under that of the fit.
    pub fn linearised<'a>(
        &self,
        fit: &'a Fit,
        data: &'a Dataset,
        options: &'a DiscoverOptions,
    ) -> Result<Linearisation<'a>, DiscoverError> {
        let mut linearisation = Linearisation::new(fit, data, options)?;
        linearisation.noise = self.noise_of(fit);
        Ok(linearisation)
    }

    /// The noise of the search where the joints scatter, else that of a fit.
    pub fn noise_of(&self, fit: &Fit) -> Noise {
        self.noise.unwrap_or_else(|| fit.noise.into())
    }

    /// Whether the numbers of a pose share the scatter of its joints.
    pub fn joints_scatter(&self) -> bool {
        self.noise.is_some_and(|noise| noise.joints.is_some())
    }

    /// How many units the blocks are of.
    pub fn units(&self) -> usize {
        UNITS.min(self.rows.len())
    }

    /// The unit of a block.
    pub fn unit(&self, block: usize) -> usize {
        block * self.units() / self.rows.len()
    }

    /// The stride at which a dozen blocks are seen, or a sixteenth of many.
    pub fn part(&self) -> usize {
        (self.rows.len() / 12).clamp(1, 16)
    }

    /// How many blocks there are for one at this stride.
    pub fn times(&self, stride: usize) -> f64 {
        self.rows.len() as f64 / self.rows.len().div_ceil(stride) as f64
    }

    /// The data of all blocks.
    pub fn data(&self) -> &Dataset {
        &self.data
    }

    /// The derived channels that a model and further effects read, of all rows: they follow the order of all poses, and no block has to follow it
    /// anew.
    pub fn derived<'e>(
        &self,
        fit: &'e Fit,
        effects: impl Iterator<Item = &'e Box<dyn AnyEffect>>,
    ) -> Derived {
        let model = fit.fitted.model();
        Derived::new(&self.data, model.chain(), model.effects().iter().chain(effects))
    }

    /// How many of the first of these candidates are looked at in one pass: as many as read no more channels than are kept.
    pub fn at_once(&self, candidates: &[Candidate]) -> usize {
        let mut names = BTreeSet::new();
        let fits = |candidate: &&Candidate| {
            names.extend(missing(&self.data, candidate.effects().iter()));
            names.len() <= CHANNELS
        };
        candidates.iter().take_while(fits).count().max(1)
    }

    /// The rows of the first block with these channels.
    pub fn first(&self, derived: &Derived) -> Dataset {
        derived.select(&self.data, self.rows.first().map_or(&[], Vec::as_slice))
    }

    /// Works on every `stride`-th block with these channels, several at once, and takes the results in order.
    pub fn each<T: Send>(
        &self,
        stride: usize,
        derived: &Derived,
        of: &(dyn Fn(&Dataset) -> Result<T, DiscoverError> + Sync),
        take: &mut dyn FnMut(usize, T),
    ) -> Result<(), DiscoverError> {
        let wanted: Vec<usize> = (0..self.rows.len()).step_by(stride.max(1)).collect();
        for several in wanted.chunks(AT_ONCE) {
            let results: Vec<T> = several
                .par_iter()
                .map(|&block| of(&derived.select(&self.data, &self.rows[block])))
                .collect::<Result<_, _>>()?;
            several.iter().zip(results).for_each(|(&block, result)| take(block, result));
        }
        Ok(())
    }
}
