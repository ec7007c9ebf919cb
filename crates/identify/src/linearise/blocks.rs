//! The design matrix in blocks of rows, component by component, whitened, for accumulators that leave zeros out.
//!
//! The same numbers as those of a [`super::Lineariser`], [`LANES`] rows at once. Rows in which the same joints stand at zero come together,
//! since whole columns of a model vanish there: a block has the columns of its kind and no others. Their order is a
//! function of the data alone. A visit is never cut.

use super::lineariser::Lineariser;
use crate::IdentifyError;
use crate::noise::{directions, rays_of, shrinkage};
use rayon::prelude::*;
use std::collections::HashMap;
use truepose_errormodel::batch::{Component, Lanes};
use truepose_errormodel::lanes::LANES;
use truepose_errormodel::{Dataset, Equilibrium, ErrorModel, NoiseModel, Visits};
use truepose_kinematics::Load;

/// A block that is begun with rows of another kind has at least so many.
const LEAST: usize = 8;

/// Turns blocks of visits into whitened columns.
#[derive(Debug, Clone)]
pub struct Blocks<'a> {
    lanes: Lanes<'a>,
    pub(super) data: &'a Dataset,
    noise: NoiseModel,
    coefficients: &'a [f64],
    places: Vec<Option<usize>>,
    weights: Vec<f64>,
    /// First lane of each visit of the block, and the number of lanes.
    starts: Vec<usize>,
    /// For each component: the lanes in which it was measured.
    seen: [Vec<usize>; 6],
    /// How many make batches at once.
    threads: usize,
    soft: bool,
}

/// Rows of whole visits, [`LANES`] at most.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Batch {
    /// The data's rows.
    pub rows: Vec<usize>,
    /// Where each visit begins, and the number of rows.
    pub starts: Vec<usize>,
}

/// Some visits in batches of their kinds, in a fixed order; none where a visit is longer than a block.
pub fn batches(data: &Dataset, visits: &Visits, which: impl Iterator<Item = usize>) -> Option<Vec<Batch>> {
    let zero = |row: usize| {
        let joints = data.joints.iter().enumerate();
        let standing = joints.fold(0u64, |mask, (k, q)| mask | u64::from(q[row] == 0.0) << (k % 63));
        let unloaded = match data.load[row] {
            Load::None => true,
            Load::Payload(payload) => payload.mass == 0.0,
            Load::Wrench(wrench) => (0..6).all(|k| wrench.component(k) == 0.0),
        };
        standing | u64::from(unloaded) << 63
    };
    let mut order: Vec<(u64, usize)> =
        which.filter(|&v| !visits.rows[v].is_empty()).map(|v| (zero(visits.rows[v][0]), v)).collect();
    order.sort_by_key(|(kind, _)| *kind);
    let mut made: Vec<Batch> = Vec::new();
    let mut open = Batch::default();
    let mut kind = None;
    for (of, visit) in order {
        let rows = &visits.rows[visit];
        if rows.len() > LANES {
            return None;
        }
        let other = kind.replace(of).is_some_and(|last| last != of) && open.rows.len() >= LEAST;
        if other || open.rows.len() + rows.len() > LANES {
            open.close(&mut made);
        }
        open.starts.push(open.rows.len());
        open.rows.extend_from_slice(rows);
    }
    open.close(&mut made);
    Some(made)
}

impl Batch {
    fn close(&mut self, made: &mut Vec<Batch>) {
        if !self.rows.is_empty() {
            self.starts.push(self.rows.len());
            made.push(std::mem::take(self));
        }
    }
}

impl<'a> Blocks<'a> {
    /// On these registers, instead of the widest that the processor has.
    #[cfg(test)]
    pub fn on(mut self, arch: truepose_kinematics::pulp::Arch) -> Self {
        self.lanes = self.lanes.on(arch);
        self
    }

    /// Linearises at these coefficients, over all columns or over these.
    ///
    /// # Errors
    /// When the data does not fit the robot, or lacks a signal that the model needs.
    pub fn new(
        model: &'a ErrorModel,
        data: &'a Dataset,
        noise: NoiseModel,
        coefficients: &'a [f64],
        columns: Option<&[usize]>,
    ) -> Result<Self, IdentifyError> {
        data.validate(model.chain())?;
        let count = model.columns().len();
        let places = match columns {
            None => (0..count).map(Some).collect(),
            Some(columns) => {
                let mut places = vec![None; count];
                columns.iter().enumerate().for_each(|(place, &column)| places[column] = Some(place));
                places
            }
        };
        Ok(Blocks {
            lanes: Lanes::new(model.bind(&data.schema)?),
            data,
            noise,
            coefficients,
            places,
            weights: vec![0.0; 6 * LANES],
            starts: Vec::new(),
            seen: Default::default(),
            threads: 1,
            soft: Equilibrium::is_soft(model, data, coefficients)?,
        })
    }

    /// Some visits in batches; none where they have to be linearised row by row: a visit is longer than a block, or the robot is soft, so that slopes
    /// are those of [`truepose_errormodel::Equilibrium::slope`].
    pub(super) fn batches(&self, visits: &Visits, which: impl Iterator<Item = usize>) -> Option<Vec<Batch>> {
        if self.soft { None } else { batches(self.data, visits, which) }
    }

    /// With so many threads where batches are made one after the other.
    pub(super) fn on_threads(mut self, threads: usize) -> Self {
        /// Each has memory of its own.
        const MOST: usize = 8;
        self.threads = threads.clamp(1, MOST);
        self
    }

    /// The same rows one by one, for visits that are longer than a block.
    pub(super) fn row_by_row(&self) -> Result<Lineariser<'a>, IdentifyError> {
        let model = self.lanes.bound().model();
        let mut columns = vec![0; self.width()];
        for (column, place) in self.places.iter().enumerate().filter_map(|(c, place)| Some((c, (*place)?))) {
            columns[place] = column;
        }
        Ok(Lineariser::new(model, self.data, self.noise, self.coefficients)?.of_columns(&columns))
    }

    /// How many columns there are.
    pub fn width(&self) -> usize {
        self.places.iter().flatten().count()
    }

    /// Makes the whitened columns of a batch, and hands them on component by component.
    ///
    /// # Errors
    /// What `each` returns.
    pub fn each(
        &mut self,
        batch: &Batch,
        mut each: impl FnMut(Component<'_>) -> Result<(), IdentifyError>,
    ) -> Result<(), IdentifyError> {
        self.lanes.gather(self.data, &batch.rows);
        self.lanes.settle(self.data, self.coefficients);
        self.weigh(&batch.rows);
        self.lanes.columns(self.data, &self.weights, &self.places);
        self.starts.clone_from(&batch.starts);
        for index in 0..6 {
            if index < 3 && self.noise.visit_sd > 0.0 {
                match index == 0 && self.data.rays().is_some() {
                    true => self.share_along(&batch.rows),
                    false => self.share(index),
                }
            }
            let rows = self.pack(index);
            let component = self.lanes.component(index);
            if !component.numbers.is_empty() {
                each(Component { rows, ..component })?;
            }
        }
        Ok(())
    }

    /// Puts the rows that were measured to the front; how many there are.
    fn pack(&mut self, component: usize) -> usize {
        let weights = &self.weights[component * LANES..];
        let rows = self.starts.last().copied().unwrap_or(0);
        let seen = &mut self.seen[component];
        seen.clear();
        seen.extend((0..rows).filter(|&lane| weights[lane] != 0.0));
        if seen.len() < rows {
            let (_, numbers) = self.lanes.component_mut(component);
            for column in numbers.chunks_exact_mut(LANES) {
                seen.iter().enumerate().for_each(|(to, &from)| column[to] = column[from]);
            }
        }
        seen.len()
    }

    /// The same, all components at once: rows × columns over the columns, ascending, that any of them has, and the residual.
    fn whole(&mut self, batch: &Batch, whole: &mut Whole) -> Result<(), IdentifyError> {
        whole.active.clear();
        whole.groups.clear();
        let mut rows = 0;
        self.each(batch, |component| {
            whole.active.extend_from_slice(component.active);
            rows += component.rows;
            Ok(())
        })?;
        whole.active.sort_unstable();
        whole.active.dedup();
        let place: HashMap<usize, usize> =
            whole.active.iter().enumerate().map(|(at, &column)| (column, at)).collect();
        whole.rows = rows;
        whole.numbers.clear();
        whole.numbers.resize((whole.active.len() + 1) * rows, 0.0);
        let mut first = 0;
        for component in (0..6).map(|index| self.lanes.component(index)).filter(|c| !c.numbers.is_empty()) {
            let seen = &self.seen[component.index];
            for (slot, from) in
                component.numbers.chunks_exact(LANES).take(component.active.len() + 1).enumerate()
            {
                let at = component.active.get(slot).map_or(whole.active.len(), |column| place[column]);
                whole.numbers[at * rows + first..][..seen.len()].copy_from_slice(&from[..seen.len()]);
            }
            first += seen.len();
            whole.groups.extend(seen.iter().map(|&lane| self.data.visit[batch.rows[lane]]));
        }
        Ok(())
    }

    /// The same of some batches.
    pub(super) fn wholes(&mut self, batches: &[Batch]) -> Result<Vec<Whole>, IdentifyError> {
        let made = batches.iter().map(|batch| {
            let mut whole = Whole::default();
            self.whole(batch, &mut whole).map(|()| whole)
        });
        made.collect()
    }

    /// The same of batch after batch, which are made by all threads and handed on in their order.
    pub(super) fn in_turn(
        &self,
        batches: &[Batch],
        mut each: impl FnMut(&Whole) -> Result<(), IdentifyError>,
    ) -> Result<(), IdentifyError> {
        let mut makers = vec![(self.clone(), Whole::default()); self.threads.min(batches.len().max(1))];
        for group in batches.chunks(makers.len()) {
            let made =
                makers.par_iter_mut().zip(group).map(|((blocks, whole), batch)| blocks.whole(batch, whole));
            made.collect::<Result<(), _>>()?;
            makers.iter().zip(group).try_for_each(|((_, whole), _)| each(whole))?;
        }
        Ok(())
    }

    /// One over the standard deviation of each component of each row; zero where nothing was measured.
    fn weigh(&mut self, rows: &[usize]) {
        let along = self.data.rays().is_some();
        for (lane, &row) in rows.iter().enumerate() {
            let one = along && self.data.ray(row).is_some();
            for k in 0..3 {
                let seen = if one { k == 0 } else { !self.data.position[row][k].is_nan() };
                let weight = 1.0 / self.noise.position(self.data.position_sd[row][k]);
                self.weights[k * LANES + lane] = if seen { weight } else { 0.0 };
                let seen = self.data.orientation[row].is_some();
                let weight = 1.0 / self.noise.orientation(self.data.orientation_sd[row][k]);
                self.weights[(3 + k) * LANES + lane] = if seen { weight } else { 0.0 };
            }
        }
    }

    /// The same where rows measured numbers along directions of their own.
    fn share_along(&mut self, batch: &[usize]) {
        let visits: Vec<(std::ops::Range<usize>, Vec<Vec<f64>>)> = (self.starts.windows(2))
            .map(|ends| {
                let lanes = ends[0]..ends[1];
                let seen = lanes.clone().filter(|&lane| self.weights[lane] != 0.0);
                let rays = rays_of(self.data, 0, seen.map(|lane| batch[lane]));
                // What was not measured weighs nothing, whatever its direction.
                let rays: Vec<_> = match rays.is_empty() {
                    true => rays,
                    false => {
                        lanes.clone().map(|lane| self.data.ray(batch[lane]).unwrap_or_default()).collect()
                    }
                };
                let along = directions(&self.weights[lanes.clone()], &rays);
                (lanes, along)
            })
            .collect();
        let (_, numbers) = self.lanes.component_mut(0);
        for column in numbers.chunks_exact_mut(LANES) {
            for (lanes, along) in &visits {
                for v in along {
                    let shrink = shrinkage(self.noise.visit_sd, v.iter().map(|v| v * v).sum());
                    let u = &mut column[lanes.clone()];
                    let dot: f64 = v.iter().zip(u.iter()).map(|(v, u)| v * u).sum();
                    u.iter_mut().zip(v).for_each(|(u, v)| *u -= shrink * dot * v);
                }
            }
        }
    }

    /// Takes out of each visit what its rows share: the rank-one formula of [`crate::NoiseModel`].
    fn share(&mut self, component: usize) {
        let weights = &self.weights[component * LANES..][..LANES];
        let rho = self.noise.visit_sd;
        let visits: Vec<(std::ops::Range<usize>, f64)> = self
            .starts
            .windows(2)
            .map(|ends| {
                let squares: f64 = weights[ends[0]..ends[1]].iter().map(|w| w * w).sum();
                (ends[0]..ends[1], shrinkage(rho, squares))
            })
            .collect();
        let size = visits.first().map_or(0, |(lanes, _)| lanes.len());
        let equal = visits.iter().all(|(lanes, _)| lanes.len() == size);
        let rows = self.starts.last().copied().unwrap_or(0);
        let shrinks: Vec<f64> = visits.iter().map(|(_, shrink)| *shrink).collect();
        let weights = &weights[..rows];
        let (_, numbers) = self.lanes.component_mut(component);
        for column in numbers.chunks_exact_mut(LANES) {
            // Mostly every visit sees the same few targets.
            match size {
                1 if equal => take_out::<1>(&mut column[..rows], weights, &shrinks),
                2 if equal => take_out::<2>(&mut column[..rows], weights, &shrinks),
                3 if equal => take_out::<3>(&mut column[..rows], weights, &shrinks),
                4 if equal => take_out::<4>(&mut column[..rows], weights, &shrinks),
                _ => {
                    for (lanes, shrink) in &visits {
                        let d = &weights[lanes.clone()];
                        let u = &mut column[lanes.clone()];
                        let along: f64 = d.iter().zip(u.iter()).map(|(d, u)| d * u).sum();
                        u.iter_mut().zip(d).for_each(|(u, d)| *u -= shrink * along * d);
                    }
                }
            }
        }
    }
}

/// Takes out of each visit of N rows what its rows share.
fn take_out<const N: usize>(column: &mut [f64], weights: &[f64], shrinks: &[f64]) {
    let (visits, _) = column.as_chunks_mut::<N>();
    let (weights, _) = weights.as_chunks::<N>();
    for ((u, d), shrink) in visits.iter_mut().zip(weights).zip(shrinks) {
        let mut along = 0.0;
        (0..N).for_each(|k| along += d[k] * u[k]);
        (0..N).for_each(|k| u[k] -= shrink * along * d[k]);
    }
}

/// All components of a batch.
#[derive(Debug, Clone, Default)]
pub(super) struct Whole {
    pub(super) active: Vec<usize>,
    pub(super) rows: usize,
    /// The visit of each row.
    pub(super) groups: Vec<usize>,
    pub(super) numbers: Vec<f64>,
}
