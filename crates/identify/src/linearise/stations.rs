//! Where a robot comes to rest in every row, found once: what other effects would do there is then asked again and again.
//!
//! A search for nonlinear parameters takes the columns of one effect at hundreds of trial values, while the robot that they are added to stands
//! still. Its static equilibrium and the error Jacobian of every row are most of the work.

use nalgebra::Vector3;
use truepose_errormodel::Equilibrium;

/// The robot at rest and its error Jacobian, for some rows of a data set.
#[derive(Debug)]
pub(crate) struct Stations {
    pub(super) rests: Vec<Equilibrium>,
    /// For each row of the data: its place in `rests` and in `sites`; none of a row that was not asked for.
    pub(super) places: Vec<Option<(usize, usize)>>,
    /// Columns of J_e, position and rotation, sites × rows.
    pub(super) sites: Vec<[Vector3<f64>; 2]>,
    pub(super) site_count: usize,
}

impl Stations {
    /// The robot at rest in a row that was asked for.
    pub fn rest(&self, row: usize) -> &Equilibrium {
        &self.rests[self.places[row].map_or(0, |(rest, _)| rest)]
    }

    /// The columns of J_e of a row that was asked for, site by site.
    pub fn sites(&self, row: usize) -> &[[Vector3<f64>; 2]] {
        let at = self.places[row].map_or(0, |(_, at)| at) * self.site_count;
        &self.sites[at..at + self.site_count]
    }
}
