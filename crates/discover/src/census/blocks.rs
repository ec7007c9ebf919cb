//! Rows in blocks of whole poses.

use crate::error::DiscoverError;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::problem::noise::Noise;
use rayon::prelude::*;
use std::borrow::Cow;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, Visits};
use truepose_identify::Fit;
use truepose_kinematics::Chain;

/// Rows of a block, at most about.
const ROWS: usize = 2048;
/// Blocks that are worked on before their results are taken: no more are in memory.
const AT_ONCE: usize = 8;
/// Contiguous parts of the data, at most, whose scores are kept apart.
const UNITS: usize = 60;

/// Rows in blocks of whole poses, in their order.
pub(crate) struct Blocks {
    /// With the derived channels that any candidate reads: they follow the order of all poses.
    data: Dataset,
    rows: Vec<Vec<usize>>,
    /// The noise of the search where the joints scatter.
    noise: Option<Noise>,
}

impl Blocks {
    /// Of these rows.
    pub fn new(chain: &Chain, data: &Dataset, options: &DiscoverOptions) -> Result<Self, DiscoverError> {
        let candidates = options.library.candidates(chain, data);
        let mut data = data.clone();
        for candidate in &candidates {
            let effects: Vec<Box<dyn AnyEffect>> = candidate.effects().to_vec();
            // What the data does not have cannot be derived from it; such a candidate has no columns.
            let Ok(model) = ErrorModel::new(chain.clone(), effects) else { continue };
            if let Ok(Cow::Owned(more)) = data.derived_for(&model) {
                data = more;
            }
        }
        let size = (data.len() / UNITS).clamp(1, ROWS);
        let mut rows: Vec<Vec<usize>> = Vec::new();
        for own in Visits::of(&data).rows {
            match rows.last_mut() {
                Some(block) if block.len() < size => block.extend(own),
                _ => rows.push(own),
            }
        }
        Ok(Blocks { data, rows, noise: None })
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
        linearisation.noise = self.noise.unwrap_or(linearisation.noise);
        Ok(linearisation)
    }

    /// How many units the blocks are of.
    pub fn units(&self) -> usize {
        UNITS.min(self.rows.len())
    }

    /// The unit of a block.
    pub fn unit(&self, block: usize) -> usize {
        block * self.units() / self.rows.len()
    }

    /// The data of all blocks.
    pub fn data(&self) -> &Dataset {
        &self.data
    }

    /// Works on every `stride`-th block, several at once, and takes the results in order.
    pub fn each<T: Send>(
        &self,
        stride: usize,
        of: &(dyn Fn(&Dataset) -> Result<T, DiscoverError> + Sync),
        take: &mut dyn FnMut(usize, T),
    ) -> Result<(), DiscoverError> {
        let wanted: Vec<usize> = (0..self.rows.len()).step_by(stride.max(1)).collect();
        for several in wanted.chunks(AT_ONCE) {
            let results: Vec<T> = several
                .par_iter()
                .map(|&block| of(&self.data.select(&self.rows[block])))
                .collect::<Result<_, _>>()?;
            several.iter().zip(results).for_each(|(&block, result)| take(block, result));
        }
        Ok(())
    }
}
