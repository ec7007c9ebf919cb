//! Lanes in which two points of the robot met: the position, its levers and the axes of targets are those of the difference of both
//! ([`crate::Aim`]), as [`crate::ErrorJacobian`] has them for one row.

use super::errors::LaneErrors;
use super::store::Store;
use super::width::LANES;
use crate::Aim;
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Chain, FrameId};

impl Store {
    /// The frames as they stood before differences were made.
    pub(super) fn rejoin(&mut self) {
        let parted = std::mem::take(&mut self.parted);
        let lanes = (0..self.met.len()).filter(|&lane| self.met[lane].is_some()).collect::<Vec<_>>();
        for (lane, before) in lanes.into_iter().zip(parted.chunks_exact(9 * self.frames)) {
            for (row, value) in before.iter().enumerate() {
                let row = self.before(0) + row;
                self.row_mut(row)[lane] = *value;
            }
        }
    }

    /// Makes differences of positions and of the levers of these frames, those of the lane's own point being there. Such a lane has no
    /// orientation.
    pub(super) fn part_from_met(&mut self, chain: &Chain, errors: &LaneErrors, frames: &[bool]) {
        for lane in 0..self.met.len() {
            let Some((tool, target)) = self.met[lane] else { continue };
            let first = self.before(0);
            for row in first..first + 9 * self.frames {
                let value = self.row(row)[lane];
                self.parted.push(value);
            }
            let behind = self.frame(tool.0, lane);
            let aimed = target.map_or_else(Vector3::zeros, |target| {
                let nominal = chain.targets()[target.0].position;
                Vector3::from_fn(|k, _| nominal[k] + errors.target(chain, target, k, lane))
            });
            let met = behind.apply(&aimed);
            let own = self.vector(self.point(), lane);
            for (k, value) in behind.rotation.iter().enumerate() {
                let row = self.met_axes() + k;
                self.row_mut(row)[lane] = *value;
            }
            let [carries_own, carries_met] = [Some(self.own_tool(lane)), chain.tool_of(tool)]
                .map(|tool| move |frame: usize| tool.is_some_and(|tool| chain.carries(FrameId(frame), tool)));
            for (frame, &wanted) in frames.iter().enumerate().take(self.frames) {
                let (a, b) = (carries_own(frame), carries_met(frame));
                if wanted {
                    let origin = self.vector(self.place(frame), lane);
                    let part = |carries: bool, point: &Vector3<f64>| {
                        if carries { point - origin } else { Vector3::zeros() }
                    };
                    let arm = (part(a, &own) - part(b, &met)) * Aim::CONTRAST;
                    for k in 0..3 {
                        let made = self.vector(self.axes(frame) + 3 * k, lane).cross(&arm);
                        let lever = self.lever(frame) + 3 * k;
                        (0..3).for_each(|c| self.row_mut(lever + c)[lane] = made[c]);
                    }
                }
                let share = (f64::from(a) - f64::from(b)) * Aim::CONTRAST;
                let before = self.before(frame);
                (0..9).for_each(|k| self.row_mut(before + k)[lane] *= share);
            }
            let way = (own - met) * Aim::CONTRAST;
            let point = self.point();
            (0..3).for_each(|c| self.row_mut(point + c)[lane] = way[c]);
        }
    }

    /// What a unit of each component of a target's error does to the position of a lane, by columns; zero where it is not measured.
    pub(super) fn carried_in(&self, target: usize, lane: usize) -> Matrix3<f64> {
        let at = |first: usize| Matrix3::from_fn(|c, k| self.row(first + 3 * k + c)[lane]);
        let own = self.target[lane].is_some_and(|t| t.0 == target);
        let axes = if own { at(self.tool().0) } else { Matrix3::zeros() };
        match self.met.get(lane).copied().flatten() {
            None => axes,
            Some((_, Some(met))) if met.0 == target => (axes - at(self.met_axes())) * Aim::CONTRAST,
            Some(_) => axes * Aim::CONTRAST,
        }
    }

    /// Three rows of a lane.
    fn vector(&self, first: usize, lane: usize) -> Vector3<f64> {
        Vector3::from_fn(|c, _| self.numbers[(first + c) * LANES + lane])
    }
}
