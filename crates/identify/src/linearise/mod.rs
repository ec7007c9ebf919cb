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
//! Rows of the same conditions, as those of several targets in one standstill, share one robot at rest; a fit that has
//! decided which columns it keeps asks for those alone.

mod blocks;
mod stations;

pub(crate) use blocks::dense;
pub use blocks::{Batch, Blocks, batches, gram, left_out, left_over, triangular, triangular_of};
pub(crate) use stations::Stations;

use crate::{IdentifyError, NoiseModel, Residuals, noise::whiten};
use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;
use std::ops::Range;
use truepose_errormodel::{BoundModel, Dataset, Emission, ErrorJacobian, ErrorModel, Rest, Visits};
use truepose_kinematics::{Conditions, rotation_log};
use truepose_solvers::accumulator::{Factor, Triangular};

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
    rest: Rest,
    /// Where the robot came to rest in every row, when that was found before.
    stations: Option<&'a Stations>,
    /// The row whose conditions the robot at rest has.
    settled: Option<usize>,
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
            rest: Rest::new(model),
            settled: None,
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
        Ok(Lineariser { robot, rest: Rest::new(model), ..self })
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
        let target = self.data.target[row];
        let jacobian = ErrorJacobian::new(chain, real, errors, target);
        if width > 1 {
            for (index, site) in self.sites.iter_mut().enumerate() {
                let at = chain.site_at(index);
                *site = [jacobian.position(at), jacobian.rotation(at)];
            }
            add(&mut self.block, emission, &self.sites);
        }
        let difference = self.data.measured_position(row) - jacobian.point();
        for k in 0..3 {
            if place[k] != usize::MAX {
                self.block[place[k] + width - 1] = difference[k];
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
        match &self.robot {
            Some((robot, coefficients)) => {
                self.rest.settle(robot, &self.conditions, coefficients);
                self.rest.emit(&self.bound, &self.conditions, &mut self.beside);
            }
            None => self.rest.settle(&self.bound, &self.conditions, self.coefficients),
        }
    }

    fn whiten_block(&mut self, rows: &[usize]) {
        let width = self.dot.len();
        let mut members = [0usize; 64];
        let mut sd = [0.0; 64];
        let (mut many_members, mut many_sd) = (Vec::new(), Vec::new());
        for component in 0..6 {
            let of_component = self.source.iter().enumerate().filter(|(_, s)| s.1 == component);
            let deviation = |row: usize| {
                if component < 3 {
                    self.noise.position(self.data.position_sd[row][component])
                } else {
                    self.noise.orientation(self.data.orientation_sd[row][component - 3])
                }
            };
            let shared = if component < 3 { self.noise.visit_sd } else { 0.0 };
            // A visit rarely has more than a few dozen rows; beyond that the lists go to the heap.
            if rows.len() <= members.len() {
                let mut count = 0;
                for (index, &(row, _)) in of_component {
                    (members[count], sd[count]) = (index, deviation(row));
                    count += 1;
                }
                whiten(&mut self.block, width, &members[..count], &sd[..count], shared, &mut self.dot);
            } else {
                many_members.clear();
                many_sd.clear();
                for (index, &(row, _)) in of_component {
                    many_members.push(index);
                    many_sd.push(deviation(row));
                }
                whiten(&mut self.block, width, &many_members, &many_sd, shared, &mut self.dot);
            }
        }
    }
}

/// Folds these visits into the triangular factor of `[A | r]`, over these columns.
///
/// # Errors
/// When the model and the data do not fit, or a number is not finite.
pub fn accumulate(
    mut lineariser: Lineariser<'_>,
    visits: &Visits,
    which: impl Iterator<Item = usize>,
) -> Result<Triangular, IdentifyError> {
    let mut factor = Triangular::new(lineariser.width() - 1, 1);
    for visit in which {
        factor.update_rows(lineariser.visit(&visits.rows[visit]).rows)?;
    }
    Ok(factor)
}

/// How many visits one block of work takes at the most: many, since rows of a kind are brought together within it.
const VISITS_PER_BLOCK: usize = 4096;
/// From so many visits times columns on there are two blocks at least: with fewer, bringing two triangles together costs what it gains,
/// and two sums of products next to nothing.
const WORTH_TWO_TRIANGLES: usize = 150_000;
const WORTH_TWO_SUMS: usize = 15_000;

/// Does one thing to every block of visits, in parallel; what comes of it is in their order. Blocks are a function of the
/// number of visits and columns alone, so that results do not depend on the number of threads, of which each block is told its share.
fn by_blocks<T: Send>(
    visits: &Visits,
    columns: usize,
    worth_two: usize,
    work: impl Fn(Range<usize>, usize) -> Result<T, IdentifyError> + Sync,
) -> Result<Vec<T>, IdentifyError> {
    let count = visits.len();
    let two = count * columns >= worth_two;
    let length = if two { VISITS_PER_BLOCK.min(count.div_ceil(2)) } else { VISITS_PER_BLOCK };
    let blocks = count.div_ceil(length);
    let each = rayon::current_num_threads().div_ceil(blocks.max(1));
    (0..blocks)
        .into_par_iter()
        .map(|block| work(block * length..((block + 1) * length).min(count), each))
        .collect()
}

/// The triangular factor of all visits over all columns, or over these: in parallel over fixed blocks that are merged in order.
///
/// # Errors
/// As [`accumulate`].
pub fn factorise(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
    columns: Option<&[usize]>,
) -> Result<Factor, IdentifyError> {
    Ok(triangular(model, data, visits, noise, coefficients, columns)?.into_factor())
}

/// What is left at these coefficients: the residuals, and the sum of their whitened squares.
///
/// # Errors
/// When the model and the data do not fit.
pub(crate) fn misfit(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
) -> Result<(Residuals, f64), IdentifyError> {
    let residuals = left_over(model, data, coefficients, &vec![0.0; coefficients.len()])?;
    let mut squares = 0.0;
    let (mut numbers, mut sd) = (Vec::new(), Vec::new());
    for rows in &visits.rows {
        for component in 0..6 {
            numbers.clear();
            sd.clear();
            for &row in rows {
                let (value, deviation) = match (component, residuals.orientation[row]) {
                    (0..3, _) if data.position[row][component].is_nan() => continue,
                    (0..3, _) => {
                        (residuals.position[row][component], noise.position(data.position_sd[row][component]))
                    }
                    (_, Some(turn)) => {
                        (turn[component - 3], noise.orientation(data.orientation_sd[row][component - 3]))
                    }
                    _ => continue,
                };
                // A step that leads nowhere is the worst one.
                if value.is_nan() {
                    return Ok((residuals, f64::INFINITY));
                }
                numbers.push(value);
                sd.push(deviation);
            }
            let shared = if component < 3 { noise.visit_sd } else { 0.0 };
            let places: Vec<usize> = (0..numbers.len()).collect();
            whiten(&mut numbers, 1, &places, &sd, shared, &mut [0.0]);
            squares += numbers.iter().map(|v| v * v).sum::<f64>();
        }
    }
    Ok((residuals, squares))
}

/// All whitened rows at once.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// A, rows × p.
    pub a: DMatrix<f64>,
    /// r, rows.
    pub residual: DVector<f64>,
    /// The visit of each row.
    pub visit: Vec<usize>,
}

/// The whitened residuals of all rows, in the order of [`collect`], without any column.
pub(crate) fn left_over_rows(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
) -> Result<Rows, IdentifyError> {
    gathered(Lineariser::new(model, data, noise, coefficients)?.of_columns(&[]), visits)
}

/// All whitened rows as one matrix, for solvers that have to see rows.
///
/// # Errors
/// When the model and the data do not fit.
pub fn collect(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
) -> Result<Rows, IdentifyError> {
    gathered(Lineariser::new(model, data, noise, coefficients)?, visits)
}

fn gathered(mut lineariser: Lineariser<'_>, visits: &Visits) -> Result<Rows, IdentifyError> {
    let width = lineariser.width();
    let (mut flat, mut visit) = (Vec::new(), Vec::new());
    for (k, rows) in visits.rows.iter().enumerate() {
        let block = lineariser.visit(rows);
        flat.extend_from_slice(block.rows);
        visit.resize(visit.len() + block.source.len(), k);
    }
    let whole = DMatrix::from_row_slice(visit.len(), width, &flat);
    let residual = whole.column(width - 1).into_owned();
    Ok(Rows { a: whole.remove_column(width - 1), residual, visit })
}
