//! The joints of the nominal robot that belong to a pose of a program.

use super::configuration::{Arm, degrees, turns_fit};
use crate::ControllerError;
use crate::program::Branch;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use truepose_compensate::{Compensator, CompensatorOptions, Status, Target};
use truepose_errormodel::{FittedModel, Schema};
use truepose_kinematics::{Chain, Conditions, JointKind, Pose};

/// Joints farther than this from the point before, rad, are compared with all others that reach the pose.
const FAR: f64 = 0.5;

/// The next nearest configuration has to be so many times as far away as the nearest.
const CLEARLY: f64 = 1.5;

/// Joints closer than this are one solution, rad or m.
const SAME: f64 = 1e-6;

pub(super) struct Inverse<'m> {
    chain: &'m Chain,
    nominal: Compensator<'m>,
    arm: Option<Arm<'m>>,
    turn_axes: Option<[usize; 3]>,
}

impl<'m> Inverse<'m> {
    /// Of a fit without errors.
    pub(super) fn new(
        ideal: &'m FittedModel,
        turn_axes: Option<[usize; 3]>,
    ) -> Result<Self, ControllerError> {
        let options = CompensatorOptions { starts: 0, ..CompensatorOptions::default() };
        let nominal = Compensator::bind(ideal, &Schema::default(), options)?;
        Ok(Inverse { chain: ideal.chain(), nominal, arm: Arm::of(ideal.chain()), turn_axes })
    }

    /// Variables at which the nominal flange is here (robot's base), in the configuration of the branch; `before` are those of the point
    /// before.
    ///
    /// # Errors
    /// Why there are none, or which ones is not known.
    pub(super) fn joints(
        &mut self,
        flange: &Pose,
        branch: &Branch,
        before: Option<&[f64]>,
    ) -> Result<Vec<f64>, String> {
        if self.chain.movable().len() != 6 {
            return Err("a pose is read for arms of six joints; give the point in joint values".into());
        }
        let tool = self.chain.base().pose * *flange * self.chain.tool().pose;
        match branch {
            Branch::Kuka { .. } | Branch::Abb(_) | Branch::Fanuc { .. } => self.described(&tool, branch, before),
            Branch::Near(joints) => {
                let mut near = joints.clone();
                if near.len() != 6 {
                    return Err("the joints near it are not six".into());
                }
                self.chain.joints_from_controller(&mut near);
                self.nearest(&tool, &near)
            }
            Branch::Continuous | Branch::Opaque(_) => match before {
                Some(before) => self.nearest(&tool, before),
                None => Err("the arm's configuration is not known here: no point with known joints is before it (--start)".into()),
            },
        }
    }

    /// One solution from a seed.
    fn from(&mut self, tool: &Pose, seed: &[f64]) -> Option<Vec<f64>> {
        let target = Target::at(tool.translation).turned(tool.rotation);
        let command = self.nominal.command(&target, &Conditions::at(self.chain, seed), Some(seed));
        (command.status == Status::Ok).then(|| command.joints.to_vec())
    }

    /// All solutions that were found, whole turns included.
    fn all(&mut self, tool: &Pose, first: Option<&[f64]>) -> Vec<Vec<f64>> {
        let mut found: Vec<Vec<f64>> = Vec::new();
        let mut seeds: Vec<Vec<f64>> = first.map(<[f64]>::to_vec).into_iter().collect();
        seeds.extend(self.grid());
        let mut at = 0;
        while at < seeds.len() {
            let solution = self.from(tool, &seeds[at]);
            at += 1;
            let Some(mut solution) = solution else { continue };
            self.principal(&mut solution);
            if found.iter().any(|other| distance(other, &solution) < SAME) {
                continue;
            }
            // The other side of the wrist.
            for sign in [-PI, PI] {
                let mut flipped = solution.clone();
                flipped[3] += sign;
                flipped[4] = -flipped[4];
                flipped[5] -= sign;
                seeds.push(flipped);
            }
            found.push(solution);
        }
        found.iter().flat_map(|solution| self.turned(solution)).collect()
    }

    /// Seeds over the whole range of the first three joints.
    fn grid(&self) -> Vec<Vec<f64>> {
        let value = |k: usize, part: f64| {
            let joint = self.chain.joint(self.chain.movable()[k]);
            let (lower, upper) = joint.limits.unwrap_or((-PI, PI));
            let (lower, upper) = match joint.kind {
                JointKind::Revolute => (lower.max(-PI), upper.min(PI)),
                _ => (lower, upper),
            };
            lower + part * (upper - lower)
        };
        let mut seeds = Vec::new();
        for first in [0.125, 0.375, 0.625, 0.875] {
            for second in [0.2, 0.5, 0.8] {
                for third in [0.15, 0.4, 0.6, 0.85] {
                    for wrist in [0.3, 0.7] {
                        let parts = [first, second, third, 0.55, wrist, 0.55];
                        seeds.push((0..6).map(|k| value(k, parts[k])).collect());
                    }
                }
            }
        }
        seeds
    }

    fn within(&self, k: usize, value: f64) -> bool {
        let limits = self.chain.joint(self.chain.movable()[k]).limits;
        limits.is_none_or(|(lower, upper)| value >= lower && value <= upper)
    }

    /// Whole turns taken away as far as the limits allow.
    fn principal(&self, joints: &mut [f64]) {
        for (k, value) in joints.iter_mut().enumerate() {
            if self.chain.joint(self.chain.movable()[k]).kind == JointKind::Revolute {
                let short = *value - TAU * (*value / TAU).round();
                if self.within(k, short) {
                    *value = short;
                }
            }
        }
    }

    /// A solution with whole turns added in every way that the limits allow.
    fn turned(&self, solution: &[f64]) -> Vec<Vec<f64>> {
        let mut all = vec![solution.to_vec()];
        for k in 0..solution.len() {
            if self.chain.joint(self.chain.movable()[k]).kind != JointKind::Revolute {
                continue;
            }
            let more: Vec<Vec<f64>> = all
                .iter()
                .flat_map(|joints| [-TAU, TAU].map(|turn| (joints, joints[k] + turn)))
                .filter(|&(_, value)| value.abs() < 1.5 * TAU && self.within(k, value))
                .map(|(joints, value)| {
                    let mut joints = joints.clone();
                    joints[k] = value;
                    joints
                })
                .collect();
            all.extend(more);
        }
        all
    }

    /// The solution nearest to some joints.
    fn nearest(&mut self, tool: &Pose, before: &[f64]) -> Result<Vec<f64>, String> {
        if let Some(found) = self.from(tool, before)
            && found.iter().zip(before).all(|(a, b)| (a - b).abs() < FAR)
        {
            return Ok(found);
        }
        let mut all = self.all(tool, Some(before));
        all.sort_by(|a, b| distance(a, before).total_cmp(&distance(b, before)));
        match &all[..] {
            [] => Err("no joint values of the nominal robot reach it".into()),
            [best, next, ..] if distance(next, before) < CLEARLY * distance(best, before) => {
                let far = distance(best, before).to_degrees();
                Err(format!(
                    "the arm's configuration is not known: two that reach it are about equally far ({far:.0}°) from the point before"
                ))
            }
            [best, ..] => Ok(best.clone()),
        }
    }

    /// The solution that a configuration describes.
    fn described(
        &mut self,
        tool: &Pose,
        branch: &Branch,
        before: Option<&[f64]>,
    ) -> Result<Vec<f64>, String> {
        let Some(mut arm) = self.arm.take() else {
            return Err("its configuration data is not interpreted for an arm whose last three axes do not meet; give the point in joint values".into());
        };
        if let Branch::Fanuc { turns, .. } = branch
            && turns.iter().any(|&turn| turn != 0)
            && self.turn_axes.is_none()
        {
            self.arm = Some(arm);
            return Err("which axes its turn numbers are of is not known (--turn-axes)".into());
        }
        let quick = before
            .and_then(|before| self.from(tool, before))
            .filter(|found| self.fits(&mut arm, found, branch, true));
        let found = match quick {
            Some(found) => Ok(found),
            None => {
                let mut all = self.all(tool, before);
                all.retain(|joints| turns_fit(branch, &degrees(self.chain, joints), self.turn_axes));
                let turning = all.clone();
                all.retain(|joints| self.fits(&mut arm, joints, branch, true));
                // Older arms of ABB have no cfx: where the quadrants leave one solution, it is that.
                if all.is_empty() && matches!(branch, Branch::Abb([.., 0])) && turning.len() == 1 {
                    all = turning;
                }
                all.sort_by(|a, b| turned(a).total_cmp(&turned(b)));
                all.into_iter().next().ok_or_else(|| {
                    "no joint values of the nominal robot reach it in the configuration that it states".into()
                })
            }
        };
        self.arm = Some(arm);
        found
    }

    fn fits(&self, arm: &mut Arm<'_>, joints: &[f64], branch: &Branch, letters: bool) -> bool {
        turns_fit(branch, &degrees(self.chain, joints), self.turn_axes)
            && (!letters || arm.configuration(joints, branch).is_some_and(|found| found.fits(branch)))
    }

    /// Whether two postures have the same configuration, in the words of a branch.
    pub(super) fn same(&mut self, a: &[f64], b: &[f64], branch: &Branch) -> bool {
        match (&mut self.arm, branch) {
            (Some(arm), Branch::Kuka { .. } | Branch::Abb(_) | Branch::Fanuc { .. }) => {
                arm.configuration(a, branch) == arm.configuration(b, branch)
            }
            _ => distance(a, b) < FRAC_PI_2,
        }
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

fn turned(joints: &[f64]) -> f64 {
    joints.iter().map(|value| value.abs()).sum()
}
