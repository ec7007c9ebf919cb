//! The design matrix, block by block: `y − y(c) ≈ P J_e Φ δc`, whitened (Eq. 18).
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | A | first p numbers of a row | rows × p | 1 per unit of each column |
//! | r | last number of a row | rows | 1 |
//!
//! A block holds the rows of one visit, three for a measured position and three for a measured orientation, less
//! what was not seen. It is linearised at the exact real robot with coefficients c (J_e there, Φ under the weights
//! that it carries there) and handed on at once: the matrix is never whole in memory unless somebody collects it.
//! A row that measured one number along a direction has one row, of what it is along that direction ([`truepose_errormodel::Ray`]).
//! Rows of the same conditions, as those of several targets in one standstill, share one robot at rest; a fit that has
//! decided which columns it keeps asks for those alone.

use super::stations::Stations;
use crate::noise::{rays_of, whiten};
use crate::{IdentifyError, NoiseModel};
use nalgebra::{DMatrix, Vector3};
use truepose_errormodel::{BoundModel, Dataset, Emission, Equilibrium, ErrorJacobian, ErrorModel};
use truepose_kinematics::{Conditions, rotation_log};

/// Turns visits into whitened rows of `[A | r]`. Memory is used again from visit to visit.
#[derive(Debug, Clone)]
pub struct Lineariser<'a> {
    bound: BoundModel<'a>,
    data: &'a Dataset,
    noise: NoiseModel,
    coefficients: &'a [f64],
    /// Where the robot is, when it is not where these effects put it.
    robot: Option<(BoundModel<'a>, &'a [f64])>,
    conditions: Conditions,
    rest: Equilibrium,
    /// Where the robot came to rest in every row, when that was found before.
    stations: Option<&'a Stations>,
    /// The row whose conditions the robot at rest has.
    settled: Option<usize>,
    /// Of a soft robot there: what the weights make of each error.
    slope: Option<DMatrix<f64>>,
    /// What these effects say at a robot that another model describes.
    beside: Emission,
    /// The place of each column of the model in a row; none: left out.
    places: Vec<Option<u32>>,
    /// For each site: the columns of J_e, position and rotation.
    sites: Vec<[Vector3<f64>; 2]>,
    block: Vec<f64>,
    /// For each row of the block: the data's row and the component (0…2 position, 3…5 orientation).
    source: Vec<(usize, usize)>,
    dot: Vec<f64>,
}

/// The rows of one visit.
#[derive(Debug, Clone, Copy)]
pub struct Block<'b> {
    /// `[a_1 … a_p, r]`, row after row.
    pub rows: &'b [f64],
    /// For each row: the data's row and the component (0…2 position, 3…5 orientation).
    pub source: &'b [(usize, usize)],
}

impl<'a> Lineariser<'a> {
    /// Linearises at these coefficients.
    ///
    /// # Errors
    /// When the data does not fit the robot, or lacks a signal that the model needs.
    pub fn new(
        model: &'a ErrorModel,
        data: &'a Dataset,
        noise: NoiseModel,
        coefficients: &'a [f64],
    ) -> Result<Self, IdentifyError> {
        data.validate(model.chain())?;
        let columns = model.columns().len();
        Ok(Lineariser {
            bound: model.bind(&data.schema)?,
            data,
            noise,
            coefficients,
            robot: None,
            stations: None,
            conditions: Conditions::default(),
            rest: Equilibrium::of_rows(model, data, coefficients)?,
            settled: None,
            slope: None,
            beside: Emission::new(),
            places: (0..columns as u32).map(Some).collect(),
            sites: vec![[Vector3::zeros(); 2]; model.chain().site_count()],
            block: Vec::new(),
            source: Vec::new(),
            dot: vec![0.0; columns + 1],
        })
    }

    /// Rows of these columns alone, in this order, and of the residual.
    #[must_use]
    pub fn of_columns(mut self, columns: &[usize]) -> Self {
        self.places.fill(None);
        for (place, &column) in columns.iter().enumerate() {
            self.places[column] = Some(place as u32);
        }
        self.dot = vec![0.0; columns.len() + 1];
        self
    }

    /// Takes the columns at the robot that another model describes: what these effects would add to it.
    ///
    /// # Errors
    /// When the data lacks a signal that the other model needs.
    pub fn beside(self, model: &'a ErrorModel, coefficients: &'a [f64]) -> Result<Self, IdentifyError> {
        let robot = Some((model.bind(&self.data.schema)?, coefficients));
        let rest = Equilibrium::of_rows(model, self.data, coefficients)?;
        Ok(Lineariser { robot, rest, ..self })
    }

    /// Takes the columns where a robot came to rest before, row by row; residuals are zero.
    #[must_use]
    pub(crate) fn at_stations(self, stations: &'a Stations) -> Self {
        Lineariser { stations: Some(stations), ..self }
    }

    /// Numbers in a row: one for each column, and the residual.
    pub fn width(&self) -> usize {
        self.dot.len()
    }

    /// The whitened rows of one visit.
    pub fn visit(&mut self, rows: &[usize]) -> Block<'_> {
        self.raw(rows);
        self.whiten_block(rows);
        Block { rows: &self.block, source: &self.source }
    }

    /// The rows of one visit in metres and radians, not whitened.
    pub fn unweighted(&mut self, rows: &[usize]) -> Block<'_> {
        self.raw(rows);
        Block { rows: &self.block, source: &self.source }
    }

    fn raw(&mut self, rows: &[usize]) {
        self.block.clear();
        self.source.clear();
        for &row in rows {
            self.row(row);
        }
    }

    fn row(&mut self, row: usize) {
        let seen = self.data.seen(row);
        let ray = self.data.ray(row);
        let count = seen.count();
        if count == 0 {
            return;
        }
        let chain = self.bound.model().chain();
        self.settle(row);
        let width = self.dot.len();
        let start = self.block.len();
        self.block.resize(start + count * width, 0.0);
        let mut place = [usize::MAX; 6];
        let mut next = start;
        for (component, at) in place.iter_mut().enumerate() {
            if if component < 3 { seen.position[component] } else { seen.orientation } {
                *at = next;
                next += width;
                self.source.push((row, component));
            }
        }

        let add = |block: &mut [f64], emission: &Emission, sites: &[[Vector3<f64>; 2]]| {
            for entry in emission.entries() {
                let Some(column) = self.places[entry.column] else { continue };
                let [p, r] = &sites[chain.site_index(entry.site)];
                if let Some(w) = &ray {
                    block[place[0] + column as usize] += entry.value * w.dot(p);
                    continue;
                }
                for k in 0..3 {
                    if place[k] != usize::MAX {
                        block[place[k] + column as usize] += entry.value * p[k];
                    }
                }
                if seen.orientation {
                    for k in 0..3 {
                        block[place[k + 3] + column as usize] += entry.value * r[k];
                    }
                }
            }
        };
        if let Some(stations) = self.stations {
            add(&mut self.block, &self.beside, stations.sites(row));
            return;
        }
        let emission = if self.robot.is_some() { &self.beside } else { self.rest.emission() };
        let (real, errors) = (self.rest.real(), self.rest.errors());
        let jacobian = ErrorJacobian::new(chain, real, errors, self.data.aim(row));
        if width > 1 {
            for (index, site) in self.sites.iter_mut().enumerate() {
                let at = chain.site_at(index);
                *site = [jacobian.position(at), jacobian.rotation(at)];
            }
            followed(&mut self.sites, self.slope.as_ref());
            add(&mut self.block, emission, &self.sites);
        }
        let difference = self.data.measured_position(row) - jacobian.point();
        for k in 0..3 {
            if place[k] != usize::MAX {
                self.block[place[k] + width - 1] = ray.map_or(difference[k], |w| w.dot(&difference));
            }
        }
        if let Some(measured) = self.data.measured_rotation(row) {
            let turn = rotation_log(&(measured * real.tool().rotation.transpose()));
            for k in 0..3 {
                self.block[place[k + 3] + width - 1] = turn[k];
            }
        }
    }

    /// The robot at rest under the conditions of a row, unless it is there already.
    fn settle(&mut self, row: usize) {
        let alike = |other| {
            self.bound.same_conditions(self.data, other, row)
                && self.robot.as_ref().is_none_or(|(robot, _)| robot.same_conditions(self.data, other, row))
        };
        if self.settled.replace(row).is_some_and(alike) {
            return;
        }
        self.data.conditions_into(row, &mut self.conditions);
        if let Some(stations) = self.stations {
            stations.rest(row).emit(&self.bound, &self.conditions, &mut self.beside);
            return;
        }
        let (robot, coefficients) = match &self.robot {
            Some((robot, coefficients)) => (robot, *coefficients),
            None => (&self.bound, self.coefficients),
        };
        self.rest.settle(robot, &self.conditions, coefficients);
        self.slope = self.rest.slope(robot, &self.conditions, coefficients);
        if self.robot.is_some() {
            self.rest.emit(&self.bound, &self.conditions, &mut self.beside);
        }
    }

    fn whiten_block(&mut self, rows: &[usize]) {
        let width = self.dot.len();
        let (mut members, mut sd) = (Vec::with_capacity(rows.len()), Vec::with_capacity(rows.len()));
        for component in 0..6 {
            members.clear();
            sd.clear();
            for (index, &(row, _)) in self.source.iter().enumerate().filter(|(_, s)| s.1 == component) {
                members.push(index);
                sd.push(match component {
                    0..3 => self.noise.position(self.data.position_sd[row][component]),
                    _ => self.noise.orientation(self.data.orientation_sd[row][component - 3]),
                });
            }
            let shared = if component < 3 { self.noise.visit_sd } else { 0.0 };
            let rays = rays_of(self.data, component, members.iter().map(|&index| self.source[index].0));
            whiten((&mut self.block, width), &members, &sd, &rays, shared, &mut self.dot);
        }
    }
}

/// Columns of J_e, site by site, with the weights following each error: J_e (I − G)⁻¹ ([`Equilibrium::slope`]).
fn followed(sites: &mut [[Vector3<f64>; 2]], slope: Option<&DMatrix<f64>>) {
    let Some(slope) = slope else { return };
    let before = sites[..slope.nrows()].to_vec();
    for (site, column) in sites.iter_mut().zip(slope.column_iter()) {
        let part = |k: usize| before.iter().zip(column.iter()).map(|(at, share)| at[k] * *share).sum();
        *site = [part(0), part(1)];
    }
}

/// The robot at rest in these rows, with these coefficients of a model.
///
/// # Errors
/// When the data does not fit the robot, or lacks a signal that the model needs.
pub(crate) fn stand(
    model: &ErrorModel,
    data: &Dataset,
    coefficients: &[f64],
    rows: impl Iterator<Item = usize>,
) -> Result<Stations, IdentifyError> {
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
        let jacobian = ErrorJacobian::new(chain, real, errors, data.aim(row));
        let first = sites.len();
        sites.extend((0..site_count).map(|index| {
            let at = chain.site_at(index);
            [jacobian.position(at), jacobian.rotation(at)]
        }));
        followed(&mut sites[first..], lineariser.slope.as_ref());
        places[row] = Some((rests.len() - 1, count));
    }
    Ok(Stations { rests, places, sites, site_count })
}
