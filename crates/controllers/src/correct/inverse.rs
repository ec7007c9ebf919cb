//! The joints of the nominal robot that belong to a pose of a program.

use super::before::{Before, Open, Travel};
use super::configuration::{Arm, degrees, turns_fit};
use super::near::{congruent, distance};
use crate::ControllerError;
use crate::program::Branch;
use std::f64::consts::FRAC_PI_2;
use truepose_compensate::{Compensator, CompensatorOptions};
use truepose_errormodel::{FittedModel, Schema};
use truepose_kinematics::{Chain, Pose};

/// Joints farther than this from the point before, rad, are compared with all others that reach the pose.
const FAR: f64 = 0.5;

/// The next nearest configuration has to be so many times as far away as the nearest.
const CLEARLY: f64 = 1.5;

/// Why the joints of a point without configuration data are not known.
pub(super) const NOT_KNOWN: &str = "the arm's configuration is not known here: no point with known joints is before it; put one in \
                                    joint values before it";
const NOT_INTERPRETED: &str = "its configuration data is not interpreted for an arm whose last three axes do not meet; give the point in \
                               joint values";
const STATED: &str = "it in the configuration that it states";

pub(super) struct Inverse<'m> {
    pub(super) chain: &'m Chain,
    pub(super) nominal: Compensator<'m>,
    pub(super) arm: Option<Arm<'m>>,
    turn_axes: Option<[usize; 3]>,
    /// The same arm without its limits, for the reason why a point is not reached.
    pub(super) unlimited: Option<Box<Inverse<'m>>>,
}

impl<'m> Inverse<'m> {
    /// Of a fit without errors, and of the same one without limits.
    pub(super) fn new(
        ideal: &'m FittedModel,
        unlimited: Option<&'m FittedModel>,
        turn_axes: Option<[usize; 3]>,
    ) -> Result<Self, ControllerError> {
        let options = CompensatorOptions { starts: 0, ..CompensatorOptions::default() };
        let nominal = Compensator::bind(ideal, &Schema::default(), options)?;
        let unlimited = unlimited.map(|fit| Inverse::new(fit, None, turn_axes)).transpose()?.map(Box::new);
        Ok(Inverse { chain: ideal.chain(), nominal, arm: Arm::of(ideal.chain()), turn_axes, unlimited })
    }

    /// Variables at which the nominal flange is here (robot's base), in the configuration of the branch and of the motion.
    ///
    /// # Errors
    /// Why there are none, or which ones is not known.
    pub(super) fn joints(
        &mut self,
        flange: &Pose,
        branch: &Branch,
        travel: Travel,
        before: &Before,
    ) -> Result<Vec<f64>, Open> {
        if self.chain.movable().len() != 6 {
            return Err("a pose is read for arms of six joints; give the point in joint values"
                .to_owned()
                .into());
        }
        let tool = self.chain.base().pose * *flange * self.chain.tool().pose;
        match branch {
            Branch::Kuka { .. } | Branch::Abb(_) | Branch::Fanuc { .. } if travel.followed => {
                let found = self.described(&tool, branch, before);
                // A line keeps the configuration, whatever S and T are.
                let keeps =
                    matches!(branch, Branch::Kuka { .. }) && travel.linear && !before.joints.is_empty();
                match found {
                    Err(_) if keeps => self.carried(&tool, true, before),
                    found => Ok(found?),
                }
            }
            Branch::Val3 { .. } => self.sided(&tool, branch, before),
            Branch::Near(joints) => {
                let mut near = joints.clone();
                if near.len() != 6 {
                    return Err("the joints near it are not six".to_owned().into());
                }
                self.chain.joints_from_controller(&mut near);
                self.nearest(&tool, &near)
            }
            _ => self.carried(&tool, travel.linear, before),
        }
    }

    /// Whether configuration data of a point describes these joints.
    pub(super) fn states(&mut self, joints: &[f64], branch: &Branch) -> bool {
        let Some(mut arm) = self.arm.take() else { return false };
        let fits = self.fits(&mut arm, joints, branch);
        self.arm = Some(arm);
        fits
    }

    /// Whether axes 4 and 6 are nearly parallel.
    pub(super) fn stretched(&mut self, joints: &[f64]) -> bool {
        self.arm.as_mut().is_some_and(|arm| arm.stretched(joints))
    }

    /// The solution in the configuration of where the robot was.
    fn carried(&mut self, tool: &Pose, linear: bool, before: &Before) -> Result<Vec<f64>, Open> {
        if before.joints.is_empty() || (before.sides && !linear) {
            return Err(NOT_KNOWN.to_owned().into());
        }
        let mut found: Vec<Vec<f64>> = Vec::new();
        let (mut reason, mut several) = (String::new(), false);
        for from in &before.joints {
            let one = if linear { self.along(tool, from) } else { self.nearest(tool, from) };
            let more = match one {
                Ok(joints) => vec![joints],
                Err(open) => {
                    reason = open.reason;
                    several |= !open.may_be.is_empty();
                    open.may_be
                }
            };
            for joints in more {
                if !found.iter().any(|other| congruent(other, &joints)) {
                    found.push(joints);
                }
            }
        }
        match (&found[..], &before.since) {
            ([one], _) if !several => Ok(one.clone()),
            (_, Some(since)) if found.len() > 1 => {
                let reason = format!("the arm's configuration is not known since {since}");
                Err(Open { reason, may_be: found })
            }
            _ => Err(Open { reason, may_be: found }),
        }
    }

    /// The solution nearest to some joints.
    fn nearest(&mut self, tool: &Pose, before: &[f64]) -> Result<Vec<f64>, Open> {
        if let Some(found) = self.from(tool, before)
            && close(&found, before)
        {
            return Ok(found);
        }
        let mut all = self.all(tool, Some(before));
        all.sort_by(|a, b| distance(a, before).total_cmp(&distance(b, before)));
        let Some(best) = all.first().cloned() else {
            return Err(self.unreached(tool, Some(before), |_, _| true, "it").into());
        };
        let far = distance(&best, before);
        // Whole turns of an axis are the same configuration.
        let mut rivals: Vec<Vec<f64>> = Vec::new();
        for joints in all.into_iter().filter(|joints| distance(joints, before) < CLEARLY * far) {
            if !rivals.iter().any(|other| congruent(other, &joints)) {
                rivals.push(joints);
            }
        }
        if rivals.len() > 1 {
            let reason = format!(
                "the arm's configuration is not known: two that reach it are about equally far ({:.0}°) from the point before",
                far.to_degrees()
            );
            return Err(Open { reason, may_be: rivals });
        }
        Ok(best)
    }

    /// The solution at the end of a line or an arc: shoulder, elbow and wrist stay.
    fn along(&mut self, tool: &Pose, before: &[f64]) -> Result<Vec<f64>, Open> {
        let Some(mut arm) = self.arm.take() else { return self.nearest(tool, before) };
        let quick = self.from(tool, before).filter(|found| close(found, before) && arm.keeps(before, found));
        let found = match quick {
            Some(found) => Some(found),
            None => {
                let mut found = self.solutions(tool, Some(before), |_, joints| arm.keeps(before, joints));
                found.retain(|joints| arm.keeps(before, joints));
                let turned = found.iter().flat_map(|solution| self.turned(solution));
                turned.min_by(|a, b| distance(a, before).total_cmp(&distance(b, before)))
            }
        };
        self.arm = Some(arm);
        let words = "it along a line, on which shoulder, elbow and wrist stay as at the point before";
        match found {
            Some(found) => Ok(found),
            None => {
                Err(self.unreached(tool, Some(before), |arm, joints| arm.keeps(before, joints), words).into())
            }
        }
    }

    /// The solution of a configuration of which parts may be those of the point before.
    fn sided(&mut self, tool: &Pose, branch: &Branch, before: &Before) -> Result<Vec<f64>, Open> {
        if !self.arm.as_ref().is_some_and(Arm::meets) {
            return Err(NOT_INTERPRETED.to_owned().into());
        }
        let Some(from) = before.joints.first().filter(|_| !before.sides) else {
            let all = matches!(branch, Branch::Val3 { lefty: Some(_), elbow: Some(_), wrist: Some(_) });
            return match all {
                true => Ok(self.described(tool, branch, before)?),
                false => self.carried(tool, false, before),
            };
        };
        let mut all = self.all(tool, Some(from));
        let reached = !all.is_empty();
        all.retain(|joints| self.states(joints, branch));
        let nearest = all.into_iter().min_by(|a, b| distance(a, from).total_cmp(&distance(b, from)));
        match nearest {
            Some(found) => Ok(found),
            None if reached => {
                Err(self.unreached(tool, Some(from), |arm, j| states(arm, j, branch), STATED).into())
            }
            None => Err(self.unreached(tool, Some(from), |_, _| true, "it").into()),
        }
    }

    /// The solution that a configuration describes.
    fn described(&mut self, tool: &Pose, branch: &Branch, before: &Before) -> Result<Vec<f64>, String> {
        let Some(mut arm) = self.arm.take_if(|arm| arm.meets()) else {
            return Err(NOT_INTERPRETED.into());
        };
        if let Branch::Fanuc { turns, .. } = branch
            && turns.iter().any(|&turn| turn != 0)
            && self.turn_axes.is_none()
        {
            self.arm = Some(arm);
            return Err("which axes its turn numbers are of is not known (--turn-axes)".into());
        }
        let first = before.joints.first().map(Vec::as_slice);
        let quick = first
            .and_then(|before| self.from(tool, before))
            .filter(|found| self.fits(&mut arm, found, branch));
        let found = quick.or_else(|| {
            let mut found = self.solutions(tool, first, |own, joints| {
                states(&mut arm, joints, branch)
                    && own.turned(joints).iter().any(|j| own.turns_fit(j, branch))
            });
            let mut all: Vec<Vec<f64>> = found.iter().flat_map(|solution| self.turned(solution)).collect();
            all.retain(|joints| self.turns_fit(joints, branch));
            found.clone_from(&all);
            all.retain(|joints| states(&mut arm, joints, branch));
            // Older arms of ABB have no cfx: where the quadrants leave one solution, it is that.
            if all.is_empty() && matches!(branch, Branch::Abb([.., 0])) && found.len() == 1 {
                all = found;
            }
            all.into_iter().min_by(|a, b| turned(a).total_cmp(&turned(b)))
        });
        self.arm = Some(arm);
        match found {
            Some(found) => Ok(found),
            None => Err(self.unreached(tool, first, |arm, joints| states(arm, joints, branch), STATED)),
        }
    }

    fn turns_fit(&self, joints: &[f64], branch: &Branch) -> bool {
        turns_fit(branch, &degrees(self.chain, joints), self.turn_axes)
    }

    fn fits(&self, arm: &mut Arm<'_>, joints: &[f64], branch: &Branch) -> bool {
        self.turns_fit(joints, branch) && states(arm, joints, branch)
    }

    /// Whether two postures have the same configuration, in the words of a branch.
    pub(super) fn same(&mut self, a: &[f64], b: &[f64], branch: &Branch) -> bool {
        match (&mut self.arm, branch) {
            (Some(arm), Branch::Kuka { .. } | Branch::Abb(_) | Branch::Fanuc { .. }) if arm.meets() => {
                arm.configuration(a, branch) == arm.configuration(b, branch)
            }
            _ => distance(a, b) < FRAC_PI_2,
        }
    }
}

/// Whether a configuration is that of the letters of a branch.
fn states(arm: &mut Arm<'_>, joints: &[f64], branch: &Branch) -> bool {
    arm.configuration(joints, branch).is_some_and(|found| found.fits(branch))
}

fn close(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < FAR)
}

fn turned(joints: &[f64]) -> f64 {
    joints.iter().map(|value| value.abs()).sum()
}
