//! Effects, evaluated at every station of a linearisation.

use crate::error::DiscoverError;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;
use truepose_errormodel::{AnyEffect, Dataset, Emission, ErrorModel};
use truepose_kinematics::{Conditions, PostureBuffer};

/// Where the robot stood while some targets of one visit were measured: everything that an effect can depend on.
#[derive(Debug, Clone)]
pub(crate) struct Station {
    pub visit: usize,
    /// Its first row.
    pub row: usize,
    pub conditions: Conditions,
    pub nominal: Arc<PostureBuffer>,
    /// Frames and wrenches where the real robot comes to rest.
    pub settled: Arc<PostureBuffer>,
    /// Its observations.
    pub observations: Range<usize>,
}

/// (unknown, site, error of the site per expected size of the unknown).
pub(crate) type Entry = (usize, usize, f64);

/// Effects, asked at every station.
pub(crate) struct Evaluated<'s> {
    stations: &'s [Station],
    /// The data with the derived channels that these effects read: those of the linearisation, then their own.
    inputs: Cow<'s, Dataset>,
    model: ErrorModel,
    scales: Vec<f64>,
}

impl<'s> Evaluated<'s> {
    /// Effects at the stations of a linearisation at a fitted model; `inputs` are its data with the derived channels of its model.
    pub fn new(
        (fitted, stations, inputs): (&ErrorModel, &'s [Station], &'s Dataset),
        effects: &[Box<dyn AnyEffect>],
    ) -> Result<Self, DiscoverError> {
        let model = ErrorModel::new(fitted.shared_chain(), effects.to_vec())?;
        let scales = model.columns().iter().map(|column| column.scale).collect();
        Ok(Evaluated { stations, inputs: inputs.derived_for(&model)?, model, scales })
    }

    /// How many unknowns there are.
    pub fn width(&self) -> usize {
        self.scales.len()
    }

    /// Calls `each(k, entries)` for the k-th of some stations, with what they say there.
    pub fn each(
        &self,
        stations: impl Iterator<Item = usize>,
        each: &mut dyn FnMut(usize, &[Entry]),
    ) -> Result<(), DiscoverError> {
        let chain = self.model.chain();
        let bound = self.model.bind(&self.inputs.schema)?;
        let mut emission = Emission::new();
        let mut entries = Vec::new();
        for (k, station) in stations.enumerate() {
            let station = &self.stations[station];
            emission.clear();
            let more = &self.inputs.channels[station.conditions.channels.len()..];
            let conditions = if more.is_empty() {
                Cow::Borrowed(&station.conditions)
            } else {
                let mut conditions = station.conditions.clone();
                conditions.channels.extend(more.iter().map(|column| column[station.row]));
                Cow::Owned(conditions)
            };
            for (settle, buffer) in [(true, &station.settled), (false, &station.nominal)] {
                bound.emit_those(settle, &buffer.view(chain, &conditions), &mut emission);
            }
            entries.clear();
            entries.extend(
                emission
                    .entries()
                    .iter()
                    .filter(|e| e.value != 0.0)
                    .map(|e| (e.column, chain.site_index(e.site), e.value * self.scales[e.column])),
            );
            each(k, &entries);
        }
        Ok(())
    }
}
