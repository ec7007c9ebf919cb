//! The two robots that a search walks with: the exact model and the nominal one.

use super::Compensator;
use crate::arm::{Arm, Reached};
use crate::command::MOST;
use crate::real::RealArm;
use crate::search::{NominalArm, Robot, held, with_followers};
use crate::task::{Columns, Gap, Task};
use nalgebra::Vector3;
use truepose_kinematics::{Chain, Conditions};

impl<'m> Compensator<'m> {
    pub(super) fn exact(&mut self) -> ExactArm<'_, 'm> {
        ExactArm {
            real: &mut self.real,
            slides: &self.nominal,
            conditions: &mut self.conditions,
            chain: self.fitted.chain(),
            scale: &self.scale,
            at: &mut self.at,
            stays: &self.stays,
        }
    }

    pub(super) fn ideal(&mut self, point: &Vector3<f64>) -> NominalArm<'_> {
        let (arm, scale, chain) = (&self.nominal, &self.scale, self.fitted.chain());
        NominalArm { arm, point: *point, scale, chain, at: &mut self.at, stays: &self.stays }
    }
}

/// The exact model as a robot to walk with.
pub(super) struct ExactArm<'a, 'm> {
    real: &'a mut RealArm<'m>,
    slides: &'a Arm,
    conditions: &'a mut Conditions,
    chain: &'m Chain,
    scale: &'a [f64; MOST],
    at: &'a mut Reached,
    stays: &'a [bool; MOST],
}

impl Robot for ExactArm<'_, '_> {
    fn send(&mut self, x: &[f64; MOST], task: &Task) -> Gap {
        for ((q, x), scale) in self.conditions.joints.iter_mut().zip(x).zip(self.scale) {
            *q = x * scale;
        }
        self.chain.follow(&mut self.conditions.joints);
        self.real.reach(self.conditions, self.at);
        task.gap(self.at, &self.real.point(task.target))
    }

    fn columns(&self, task: &Task, columns: &mut Columns) {
        task.columns(self.slides, self.at, columns);
        with_followers(self.chain, self.scale, columns);
        held(self.stays, columns);
    }

    fn joints(&self) -> usize {
        self.slides.joints()
    }
}
