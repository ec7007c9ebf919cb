//! Φ of many effects beside a fit, in blocks of standstills.
//!
//! A model of the fit's effects and of these brings a block of visits to rest at once ([`truepose_errormodel::batch::Lanes`]); the coefficients of
//! these are zero. Φ is taken at the first row of a visit.

use crate::error::DiscoverError;
use std::ops::Range;
use truepose_errormodel::batch::Lanes;
use truepose_errormodel::lanes::LANES;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel};
use truepose_identify::Fit;

/// Effects beside a fit.
pub(crate) struct Emitted {
    model: ErrorModel,
    coefficients: Vec<f64>,
    /// Effects and unknowns of the fit.
    own: [usize; 2],
}

/// What one unknown beside the fit says of one site in successive visits, per expected size: `factor` times a value a visit.
pub(crate) struct Said<'v> {
    pub column: usize,
    pub site: usize,
    pub factor: f64,
    pub values: &'v [f64],
}

/// What is said in a block of visits, by ascending unknowns.
pub(crate) struct Block<'v> {
    /// Its visits.
    pub visits: Range<usize>,
    /// What is said.
    pub beside: Vec<Said<'v>>,
}

impl Emitted {
    /// The effects of all of these beside a fit, in parts: a model holds a limited number of unknowns.
    pub fn all<'c, T>(
        fit: &Fit,
        all: &'c [T],
        effects: impl Fn(&T) -> &[Box<dyn AnyEffect>],
    ) -> Result<Vec<(&'c [T], Self)>, DiscoverError> {
        /// Unknowns of a part, unless one alone has more.
        const MOST: usize = 2048;
        let chain = fit.fitted.chain();
        let mut parts = Vec::new();
        let mut rest = all;
        while !rest.is_empty() {
            let mut width = 0;
            let fits = |of: &&T| {
                width += effects(of).iter().map(|effect| effect.columns(chain).len()).sum::<usize>();
                width <= MOST
            };
            let (part, others) = rest.split_at(rest.iter().take_while(fits).count().max(1));
            parts.push((part, Emitted::new(fit, part.iter().flat_map(&effects))?));
            rest = others;
        }
        Ok(parts)
    }

    fn new<'e>(
        fit: &Fit,
        effects: impl Iterator<Item = &'e Box<dyn AnyEffect>>,
    ) -> Result<Self, DiscoverError> {
        let fitted = fit.fitted.model();
        let mut all = fitted.effects().to_vec();
        all.extend(effects.cloned());
        let own = [fitted.effects().len(), fitted.columns().len()];
        let model = ErrorModel::new(fitted.shared_chain(), all)?;
        let mut coefficients = fit.fitted.coefficients().to_vec();
        coefficients.resize(model.columns().len(), 0.0);
        Ok(Emitted { model, coefficients, own })
    }

    /// How many unknowns there are beside the fit.
    pub fn width(&self) -> usize {
        self.coefficients.len() - self.own[1]
    }

    /// The unknowns of some of the effects beside the fit.
    pub fn columns_of(&self, effects: Range<usize>) -> Range<usize> {
        let begins = |effect: usize| match effect {
            0 => 0,
            _ => self.model.columns_of(self.own[0] + effect - 1).end - self.own[1],
        };
        begins(effects.start)..begins(effects.end)
    }

    /// Calls `each` for block after block of visits, of which these are the first rows.
    pub fn each(
        &self,
        data: &Dataset,
        rows: &[usize],
        each: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), DiscoverError> {
        let chain = self.model.chain();
        let inputs = data.derived_for(&self.model)?;
        let mut lanes = Lanes::new(self.model.bind(&inputs.schema)?);
        for (k, rows) in rows.chunks(LANES).enumerate() {
            lanes.gather(&inputs, rows);
            lanes.settle(&inputs, &self.coefficients);
            let mut beside = Vec::new();
            for phi in lanes.phi() {
                // The fit's own are known.
                let Some(column) = phi.column.checked_sub(self.own[1]) else { continue };
                let factor = phi.factor * self.model.columns()[phi.column].scale;
                beside.push(Said { column, site: chain.site_index(phi.site), factor, values: phi.values });
            }
            beside.sort_by_key(|said| said.column);
            let first = k * LANES;
            each(Block { visits: first..first + rows.len(), beside });
        }
        Ok(())
    }
}
