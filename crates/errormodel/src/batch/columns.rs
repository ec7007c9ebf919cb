//! Columns and residuals of the block that a [`Lanes`] has gathered.

use super::engine::Lanes;
use super::fill::{Columns, Component, Fill, Left};
use crate::dataset::Dataset;
use crate::lanes::{LANES, LaneValue};
use nalgebra::Matrix3;
use truepose_kinematics::{Pose, Site};

impl Lanes<'_> {
    /// Makes the columns. `weights` has `LANES` numbers a component (one over the standard deviation; zero: not measured), `places` says where
    /// a column of the model goes; none leaves it out.
    pub fn columns(&mut self, data: &Dataset, weights: &[f64], places: &[Option<usize>]) {
        self.ready(data, |column| places[column].is_some());
        let Fill { slots, known, values, .. } = &mut self.fill;
        slots.clear();
        slots.resize(places.iter().flatten().max().map_or(0, |most| most + 1), usize::MAX);
        known.clear();
        known.resize(self.store.wrench(0), None);
        values.clear();
        values.extend((0..self.emission.count()).map(|k| {
            let numbers = self.emission.numbers(LaneValue(k as u32));
            numbers[..self.rows.len()].iter().all(|&v| v == 0.0)
        }));
        let (store, emission) = (&self.store, &self.emission);
        store.arch.dispatch(Columns { store, emission, fill: &mut self.fill, weights, places });
    }

    /// Writes what is left when the coefficients change: `y − y(c) − P J_e Φ δ`, `LANES` numbers a component, m and rad. What was not
    /// measured counts as zero.
    pub fn left(&mut self, data: &Dataset, change: &[f64], into: &mut [f64]) {
        self.ready(data, |column| change[column] != 0.0);
        self.change.clear();
        if change.iter().any(|&c| c != 0.0) {
            self.change.add(&self.emission, 0, change);
        }
        let (store, change) = (&self.store, &self.change);
        store.arch.dispatch(Left { store, change, fill: &self.fill, into });
    }

    /// Levers of the sites that columns which count speak of, and the measurements.
    fn ready(&mut self, data: &Dataset, counts: impl Fn(usize) -> bool + Copy) {
        let chain = self.bound.model().chain();
        let Fill { frames, measured, .. } = &mut self.fill;
        frames.clear();
        frames.resize(self.store.frames, false);
        let mut carried = vec![false; chain.targets().len()];
        for entry in self.emission.entries.iter().filter(|entry| counts(entry.column as usize)) {
            match entry.site {
                Site::Frame(frame, axis) => frames[frame.0] |= axis.is_rotation(),
                Site::Target(target, _) => carried[target.0] = true,
            }
        }
        self.store.reach(chain, &self.errors, frames, self.rows.len());
        carried.iter().enumerate().filter(|(_, wanted)| **wanted).for_each(|(t, _)| self.store.carry(t));
        measured.resize(12 * LANES, 0.0);
        for (lane, &row) in self.rows.iter().enumerate() {
            for (k, &v) in data.position[row].iter().enumerate() {
                measured[k * LANES + lane] = if v.is_nan() { 0.0 } else { v };
            }
            let turned = data.orientation[row].map_or_else(Matrix3::zeros, Pose::rotation_from_quaternion);
            for (k, &v) in turned.iter().enumerate() {
                measured[(3 + k) * LANES + lane] = v;
            }
        }
        self.fill.rows = self.rows.len();
        self.look_along(data, counts);
        self.fill.turned = self.rows.iter().any(|&row| data.orientation[row].is_some());
    }

    /// What rows that measured one number see along their directions.
    fn look_along(&mut self, data: &Dataset, counts: impl Fn(usize) -> bool) {
        let along = &mut self.fill.along;
        along.any = false;
        let Some(rays) = data.rays() else { return };
        let has = |&row: &usize| rays.iter().any(|ray| ray[row] != 0.0);
        along.any = self.rows.iter().any(has);
        if !along.any {
            return;
        }
        let (rows, store) = (self.rows.len(), &self.store);
        along.direction.clear();
        along.direction.resize(3 * LANES, 0.0);
        for (lane, row) in self.rows.iter().enumerate() {
            for (k, ray) in rays.iter().enumerate() {
                let plain = if k == 0 { 1.0 } else { 0.0 };
                along.direction[k * LANES + lane] = if has(row) { ray[*row] } else { plain };
            }
        }
        let project = |into: &mut [f64], direction: &[f64], of: &dyn Fn(usize, usize) -> f64| {
            for lane in 0..rows {
                into[lane] = (0..3).map(|k| direction[k * LANES + lane] * of(k, lane)).sum();
            }
            into[rows..].fill(0.0);
        };
        along.point.resize(LANES, 0.0);
        along.measured.resize(LANES, 0.0);
        project(&mut along.point, &along.direction, &|k, lane| store.row(store.point() + k)[lane]);
        let measured = &self.fill.measured;
        project(&mut along.measured, &along.direction, &|k, lane| measured[k * LANES + lane]);
        let sites = self.bound.model().chain().site_count();
        along.levers.resize(sites * LANES, 0.0);
        let mut known = vec![false; sites];
        for entry in self.emission.entries.iter().filter(|entry| counts(entry.column as usize)) {
            let site = store.index(entry.site);
            let Some(first) =
                store.of_site(entry.site, 0).filter(|_| !std::mem::replace(&mut known[site], true))
            else {
                continue;
            };
            let into = &mut along.levers[site * LANES..][..LANES];
            project(into, &along.direction, &|k, lane| store.row(first + k)[lane]);
        }
    }

    /// A component of the block, as [`Lanes::columns`] made it.
    pub fn component(&self, index: usize) -> Component<'_> {
        Component {
            index,
            active: &self.fill.active[index],
            rows: self.fill.rows,
            numbers: &self.fill.numbers[index],
        }
    }

    /// As [`Lanes::component`], to be changed.
    pub fn component_mut(&mut self, index: usize) -> (&[usize], &mut [f64]) {
        (&self.fill.active[index], &mut self.fill.numbers[index])
    }
}
