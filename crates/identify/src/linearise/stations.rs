//! Where a robot comes to rest in every row, found once: what other effects would do there is then asked again and again.
//!
//! A search for nonlinear parameters takes the columns of one effect at hundreds of trial values, while the robot that they are added to stands
//! still. Its static equilibrium and the error Jacobian of every row are most of the work.

use super::Lineariser;
use crate::{IdentifyError, NoiseModel};
use nalgebra::Vector3;
use truepose_errormodel::{Dataset, ErrorJacobian, ErrorModel, Rest};

/// The robot at rest and its error Jacobian, for some rows of a data set.
#[derive(Debug)]
pub(crate) struct Stations {
    rests: Vec<Rest>,
    /// For each row of the data: its place in `rests` and in `sites`; none of a row that was not asked for.
    places: Vec<Option<(usize, usize)>>,
    /// Columns of J_e, position and rotation, sites × rows.
    sites: Vec<[Vector3<f64>; 2]>,
    site_count: usize,
}

impl Stations {
    /// Of these rows, with these coefficients of a model.
    ///
    /// # Errors
    /// When the data does not fit the robot, or lacks a signal that the model needs.
    pub fn new(
        model: &ErrorModel,
        data: &Dataset,
        coefficients: &[f64],
        rows: impl Iterator<Item = usize>,
    ) -> Result<Self, IdentifyError> {
        let chain = model.chain();
        let mut lineariser = Lineariser::new(model, data, NoiseModel::default(), coefficients)?;
        let site_count = chain.site_count();
        let (mut rests, mut sites) = (Vec::new(), Vec::new());
        let mut places = vec![None; data.len()];
        let mut last = None;
        for (count, row) in rows.enumerate() {
            lineariser.settle(row);
            let alike = last.is_some_and(|other| lineariser.bound.same_conditions(data, other, row));
            if !alike {
                rests.push(lineariser.rest.clone());
            }
            last = Some(row);
            let (real, errors) = (lineariser.rest.real(), lineariser.rest.errors());
            let jacobian = ErrorJacobian::new(chain, real, errors, data.target[row]);
            sites.extend((0..site_count).map(|index| {
                let at = chain.site_at(index);
                [jacobian.position(at), jacobian.rotation(at)]
            }));
            places[row] = Some((rests.len() - 1, count));
        }
        Ok(Stations { rests, places, sites, site_count })
    }

    /// The robot at rest in a row that was asked for.
    pub fn rest(&self, row: usize) -> &Rest {
        &self.rests[self.places[row].map_or(0, |(rest, _)| rest)]
    }

    /// The columns of J_e of a row that was asked for, site by site.
    pub fn sites(&self, row: usize) -> &[[Vector3<f64>; 2]] {
        let at = self.places[row].map_or(0, |(_, at)| at) * self.site_count;
        &self.sites[at..at + self.site_count]
    }
}
