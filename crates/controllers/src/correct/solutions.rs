//! All joints at which the nominal robot reaches a pose.

use super::configuration::Arm;
use super::inverse::Inverse;
use super::near::distance;
use std::f64::consts::{PI, TAU};
use truepose_compensate::{Status, Target};
use truepose_kinematics::{Conditions, JointKind, Pose};

/// Joints closer than this are one solution, rad or m.
const SAME: f64 = 1e-6;

/// Most starts of a search: at a singularity there are solutions without end.
const MOST_SEEDS: usize = 400;

impl<'m> Inverse<'m> {
    /// One solution from a seed.
    pub(super) fn from(&mut self, tool: &Pose, seed: &[f64]) -> Option<Vec<f64>> {
        let target = Target::at(tool.translation).turned(tool.rotation);
        let command = self.nominal.command(&target, &Conditions::at(self.chain, seed), Some(seed));
        (command.status == Status::Ok).then(|| command.joints.to_vec())
    }

    /// All solutions that were found, without whole turns; the search ends behind the first that is enough.
    pub(super) fn solutions(
        &mut self,
        tool: &Pose,
        first: Option<&[f64]>,
        mut enough: impl FnMut(&Self, &[f64]) -> bool,
    ) -> Vec<Vec<f64>> {
        let mut found: Vec<Vec<f64>> = Vec::new();
        let mut seeds: Vec<Vec<f64>> = first.map(<[f64]>::to_vec).into_iter().collect();
        seeds.extend(self.grid());
        let mut at = 0;
        while at < seeds.len().min(MOST_SEEDS) {
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
                seeds.insert(at, flipped);
            }
            let ends = enough(self, &solution);
            found.push(solution);
            if ends {
                return found;
            }
        }
        found
    }

    /// All solutions, whole turns included.
    pub(super) fn all(&mut self, tool: &Pose, first: Option<&[f64]>) -> Vec<Vec<f64>> {
        let found = self.solutions(tool, first, |_, _| false);
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
    pub(super) fn turned(&self, solution: &[f64]) -> Vec<Vec<f64>> {
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

    /// Why no joint values within the limits reach a pose: the joint that would be beyond its limits, where there is one.
    pub(super) fn unreached(
        &mut self,
        tool: &Pose,
        first: Option<&[f64]>,
        mut right: impl FnMut(&mut Arm<'m>, &[f64]) -> bool,
        what: &str,
    ) -> String {
        let plain = format!("no joint values of the nominal robot reach {what}");
        let Some(mut free) = self.unlimited.take() else { return plain };
        let mut beyond: Option<(usize, String)> = None;
        if let Some(mut arm) = free.arm.take() {
            let mut found = free.solutions(tool, first, |_, joints| right(&mut arm, joints));
            found.retain(|joints| right(&mut arm, joints));
            for joints in found {
                let over: Vec<String> = (0..joints.len()).filter_map(|k| self.over(k, &joints)).collect();
                if !over.is_empty() && beyond.as_ref().is_none_or(|(count, _)| over.len() < *count) {
                    beyond = Some((over.len(), over.join(", ")));
                }
            }
            free.arm = Some(arm);
        }
        self.unlimited = Some(free);
        match beyond {
            Some((_, over)) => format!("{plain} within the limits: {over}"),
            None => plain,
        }
    }

    /// A joint beyond its limits, whatever its whole turns.
    fn over(&self, k: usize, joints: &[f64]) -> Option<String> {
        let joint = self.chain.joint(self.chain.movable()[k]);
        let (lower, upper) = joint.limits?;
        let turns = if joint.kind == JointKind::Revolute { vec![0.0, -TAU, TAU] } else { vec![0.0] };
        if turns.iter().any(|turn| self.within(k, joints[k] + turn)) {
            return None;
        }
        let (scale, unit) =
            if joint.kind == JointKind::Revolute { (1f64.to_degrees(), "°") } else { (1e3, " mm") };
        let [value, lower, upper] = [joints[k], lower, upper].map(|value| scale * value);
        Some(format!(
            "{} would be {value:.1}{unit} (limits: {lower:.1}{unit} to {upper:.1}{unit})",
            joint.name
        ))
    }
}
