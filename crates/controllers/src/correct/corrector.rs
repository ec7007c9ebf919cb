//! The correction of one point.

use super::before::{Before, Open, Travel};
use super::configuration::{degrees, turns_of};
use super::correction::{Correction, Outcome};
use super::external::{Arms, ENOUGH, External, STEPS};
use super::frames::Frames;
use super::inverse::{Inverse, NOT_KNOWN};
use super::options::CorrectOptions;
use super::outside::outside;
use super::placed::{Placed, Stays};
use super::signals::signals;
use super::singular::singular;
use super::taught::Learned;
use crate::program::{Branch, Carried, Point, Program, Replacement, Value};
use crate::{ControllerError, Dialect};
use truepose_compensate::{
    Compensator, CompensatorOptions, Installation, Status, Target, correction_helps, installation, radius_95,
};
use truepose_errormodel::{Channel, Coverage, FittedModel};
use truepose_kinematics::nalgebra::Matrix3;
use truepose_kinematics::{Chain, Conditions, JointKind, Load, Payload, Pose, PostureBuffer, rotation_log};

/// Corrects the points of one program.
pub(super) struct Corrector<'m> {
    dialect: Dialect,
    fitted: &'m FittedModel,
    chain: &'m Chain,
    options: &'m CorrectOptions,
    installation: Installation,
    noise: Matrix3<f64>,
    frames: Frames<'m>,
    learned: &'m Learned,
    external: &'m External,
    arms: &'m Arms,
    /// Of each arm that was needed.
    inverses: Vec<Option<Inverse<'m>>>,
    /// The arm of the point.
    at: usize,
    real: Compensator<'m>,
    coverage: Coverage<'m>,
    conditions: Conditions,
    channels: Vec<Channel>,
}

impl<'m> Corrector<'m> {
    pub(super) fn new(
        program: &'m Program,
        fitted: &'m FittedModel,
        external: &'m External,
        arms: &'m Arms,
        learned: &'m Learned,
        options: &'m CorrectOptions,
    ) -> Result<Self, ControllerError> {
        let chain = fitted.chain();
        if options.turn_axes.is_some_and(|axes| axes.iter().any(|axis| !(1..=6).contains(axis))) {
            return Err(ControllerError::Option("the axes of turn numbers are 1 to 6".into()));
        }
        let (schema, values) = signals(fitted, options)?;
        let mut conditions = Conditions::at(chain, &vec![0.0; chain.movable().len()]).with_load(options.load);
        conditions.channels = values;
        Ok(Corrector {
            dialect: program.dialect,
            fitted,
            chain,
            options,
            installation: installation(fitted)?,
            noise: Matrix3::identity() * fitted.noise.position_sd.powi(2),
            frames: Frames::new(program, options)?,
            learned,
            external,
            arms,
            inverses: arms.all().iter().map(|_| None).collect(),
            at: 0,
            real: Compensator::bind(fitted, &schema, CompensatorOptions::default())?,
            coverage: Coverage::new(fitted, &schema)?,
            conditions,
            channels: schema.channels,
        })
    }

    /// The joints before the program, as variables.
    pub(super) fn start(&self) -> Result<Option<Vec<f64>>, ControllerError> {
        let Some(start) = &self.options.start else { return Ok(None) };
        let count = self.chain.movable().len();
        if start.len() != count {
            let words = format!("the start has {} joint values, the robot {count} joints", start.len());
            return Err(ControllerError::Option(words));
        }
        let mut joints = start.clone();
        self.chain.joints_from_controller(&mut joints);
        Ok(Some(joints))
    }

    /// The correction of a point, and its joints where they are known.
    pub(super) fn point(
        &mut self,
        point: &Point,
        travel: Travel,
        before: &Before,
    ) -> (Correction, Result<Vec<f64>, Open>) {
        let (joints, placed) = match self.located(point, travel, before) {
            Ok(located) => located,
            Err(open) => {
                let mut reason = open.reason.clone();
                if reason == NOT_KNOWN && self.options.start.is_none() {
                    reason.push_str(", or state the joints before the program (--start)");
                }
                return (Correction::refused(reason), Err(open));
            }
        };
        let mut correction = Correction::refused(String::new());
        correction.nominal = Some(self.controller(&joints));
        if let Err(Stays { outcome, reason }) = self.judged(point, &joints, placed.as_ref(), &mut correction)
        {
            correction.outcome = outcome;
            correction.reason = reason;
            correction.replacement = None;
        }
        (correction, Ok(joints))
    }

    fn controller(&self, joints: &[f64]) -> Vec<f64> {
        let mut values = joints.to_vec();
        self.chain.joints_to_controller(&mut values);
        values
    }

    /// Variables of the nominal robot at a point, and its pose.
    fn located(
        &mut self,
        point: &Point,
        travel: Travel,
        before: &Before,
    ) -> Result<(Vec<f64>, Option<Placed>), Open> {
        if let Some(reason) = &point.fixed {
            return Err(reason.clone().into());
        }
        let values = self.external.values(self.chain, point, self.options, self.dialect.length())?;
        self.take_arm(&values)?;
        match &point.value {
            Value::Joints(robot) => Ok((self.variables(robot, &values)?, None)),
            Value::Pose { pose, frame, tool, branch } => {
                if let (Branch::Opaque(words), Some(other)) = (branch, &before.opaque)
                    && words != other
                {
                    return Err(format!(
                        "its configuration ({words}) is not that of the point before ({other}), and is not interpreted: put a point in \
                         joint values before it"
                    )
                    .into());
                }
                let names = (self.frames.name(frame), self.frames.name(tool));
                let (frame, tool) = (self.frames.frame(frame)?, self.frames.tool(tool)?);
                let real = (self.learned.frame(names.0, frame), self.learned.tool(names.1, tool));
                let (base, flange) = (self.options.controller_base, self.options.controller_flange);
                let mut placed = Placed {
                    pose: *pose,
                    before: base * frame,
                    behind: flange * tool,
                    real: [base * real.0, flange * real.1],
                    branch: branch.clone(),
                    stated: false,
                };
                let flange = placed.flange();
                let before = before.of(|joints| self.external.of_robot(joints));
                let inverse = self.inverse()?;
                let joints = inverse.joints(&flange, branch, travel, &before);
                let joints = joints.map_err(|open| open.of(|joints| self.external.whole(joints, &values)))?;
                let inverse = self.inverse()?;
                // ABB's older arms have no cfx.
                let followed = travel.followed && matches!(branch, Branch::Abb(_));
                placed.stated = followed || inverse.states(&joints, branch);
                Ok((self.external.whole(&joints, &values), Some(placed)))
            }
        }
    }

    /// The arm with its external axes at these values is the one of the point.
    fn take_arm(&mut self, values: &[f64]) -> Result<(), String> {
        let place = self.arms.place(values);
        self.at = place.ok_or("the robot is no single arm, of which external axes could be held")?;
        if self.inverses[self.at].is_none() {
            let (ideal, unlimited) = &self.arms.all()[self.at];
            let new = Inverse::new(ideal, unlimited.as_ref(), self.options.turn_axes);
            self.inverses[self.at] = Some(new.map_err(|error| error.to_string())?);
        }
        Ok(())
    }

    fn inverse(&mut self) -> Result<&mut Inverse<'m>, String> {
        self.inverses[self.at].as_mut().ok_or_else(|| "the arm is not known".into())
    }

    /// Units of the axes of joint points, rad or m.
    fn units(&self) -> Result<Vec<f64>, String> {
        let movable: Vec<_> = self.external.robot.iter().map(|&k| self.chain.movable()[k]).collect();
        if self.dialect == Dialect::Inform {
            let Some(pulses) = &self.options.pulses else {
                return Err("it is in pulses, and how many make a degree is not known (--pulses)".into());
            };
            return match pulses.len() == movable.len() {
                true => Ok(pulses.iter().map(|pulses| 1.0 / pulses).collect()),
                false => Err(format!("pulses are given for {} axes of {}", pulses.len(), movable.len())),
            };
        }
        let unit = |joint: &truepose_kinematics::JointId| match self.chain.joint(*joint).kind {
            JointKind::Prismatic => self.dialect.length(),
            _ => self.dialect.angle(),
        };
        Ok(movable.iter().map(unit).collect())
    }

    /// Variables of a joint point, with the external axes there.
    fn variables(&self, values: &[f64], external: &[f64]) -> Result<Vec<f64>, String> {
        let units = self.units()?;
        if values.len() < units.len() || values[units.len()..].iter().any(|&value| value != 0.0) {
            return Err(format!("it has {} axes, the robot {}", values.len(), units.len()));
        }
        let robot: Vec<f64> = values.iter().zip(&units).map(|(value, unit)| value * unit).collect();
        let mut joints = self.external.whole(&robot, external);
        self.chain.joints_from_controller(&mut joints);
        Ok(joints)
    }

    fn flange(&self, joints: &[f64]) -> Pose {
        self.chain.base().pose.inverse() * self.chain.forward(joints) * self.chain.tool().pose.inverse()
    }

    /// Fills the correction in.
    fn judged(
        &mut self,
        point: &Point,
        joints: &[f64],
        placed: Option<&Placed>,
        correction: &mut Correction,
    ) -> Result<(), Stays> {
        let flange = match placed {
            Some(placed) => placed.flange(),
            None => self.flange(joints),
        };
        let meant = placed.map_or(flange, Placed::meant);
        let desired = self.installation.base * meant * self.installation.tool;
        correction.desired = Some(desired.translation.into());
        self.conditions.joints = joints.to_vec();
        self.conditions.load = self.load(&point.carried);
        let here = self.coverage.judge(&self.conditions, None);
        outside(self.fitted, &self.channels, &self.conditions, &here.beyond)?;
        let error = here.pose.translation - desired.translation;
        if !correction_helps(&error, &here.covariance) {
            correction.outcome = Outcome::NotSignificant;
            correction.reason = "the correction is smaller than its uncertainty".into();
            let reach = radius_95(&(here.covariance + self.noise));
            correction.within_95 = Some(reach + error.norm());
            return Ok(());
        }
        // At a singularity of the wrist a small correction turns joints far.
        let robot = self.external.of_robot(joints);
        let arm: &'m Chain = self.arms.all()[self.at].0.chain();
        let mut buffer = PostureBuffer::new(arm);
        let outcome = if self.inverse()?.stretched(&robot) { Outcome::Singular } else { Outcome::Refused };
        let singularity = |reason| Stays { outcome, reason };
        // Where a joint has no effect of its own, no search finds anything.
        singular(arm, &mut buffer, &robot, &robot).map_err(singularity)?;
        let found = match self.external.any() {
            true => self.searched(joints, &desired)?,
            false => self.commanded(joints, &desired)?,
        };
        let command = self.external.of_robot(&found);
        singular(arm, &mut buffer, &robot, &command).map_err(singularity)?;
        self.conditions.joints.clone_from(&found);
        let there = self.coverage.judge(&self.conditions, None);
        outside(self.fitted, &self.channels, &self.conditions, &there.beyond)?;
        correction.within_95 = Some(radius_95(&(there.covariance + self.noise)));
        let branch = placed.map_or(&Branch::Continuous, |placed| &placed.branch);
        if !self.inverse()?.same(&robot, &command, branch) {
            let words = "the correction changes the arm's configuration: the point is at a singularity";
            return Err(singularity(words.into()));
        }
        let new = self.flange(&found);
        let moved = match placed {
            // Of the tool centre point, in the axes of the base.
            Some(placed) => {
                let before = flange * placed.behind;
                let after = new * placed.behind;
                (after.translation - before.translation, before.rotation.transpose() * after.rotation)
            }
            None => {
                let (before, after) = (flange * self.installation.tool, new * self.installation.tool);
                (after.translation - before.translation, before.rotation.transpose() * after.rotation)
            }
        };
        correction.displacement = Some(moved.0.into());
        correction.rotation = Some(rotation_log(&moved.1).norm());
        correction.corrected = Some(self.controller(&found));
        if moved.0.norm() > self.options.limit {
            return Err(format!(
                "the correction of {:.3} mm is above the limit of {:.3} mm",
                1e3 * moved.0.norm(),
                1e3 * self.options.limit
            )
            .into());
        }
        correction.replacement = Some(self.replacement(point, &found, &new, placed)?);
        correction.outcome = Outcome::Corrected;
        Ok(())
    }

    /// What the robot carries at a point.
    fn load(&self, carried: &Carried) -> Load {
        match carried {
            Carried::Mass { mass, com, .. } if self.options.program_loads => {
                let in_tool = self.installation.tool.inverse() * self.options.controller_flange;
                Load::Payload(Payload { mass: *mass, com: in_tool.apply(com) })
            }
            _ => self.options.load,
        }
    }

    /// Joints that bring the real robot there.
    fn commanded(&mut self, joints: &[f64], desired: &Pose) -> Result<Vec<f64>, String> {
        let mut target = Target::at(desired.translation);
        target.orientation = (joints.len() >= 6).then_some(desired.rotation);
        let command = self.real.command(&target, &self.conditions, Some(joints));
        match command.status {
            Status::Ok => Ok(command.joints.to_vec()),
            Status::Limit => Err("only joint values beyond their limits would reach it".into()),
            Status::Unreachable => Err("the real robot does not reach it".into()),
            Status::NotConverged => Err("no joint values were found that reach it".into()),
        }
    }

    /// The same with the external axes held.
    fn searched(&mut self, joints: &[f64], desired: &Pose) -> Result<Vec<f64>, String> {
        let mut at = joints.to_vec();
        let (base, tool) = (self.installation.base.inverse(), self.installation.tool.inverse());
        for _ in 0..STEPS {
            self.conditions.joints.clone_from(&at);
            let real = self.coverage.judge(&self.conditions, None).pose;
            let step = *desired * real.inverse();
            let nominal = self.installation.base * self.flange(&at) * self.installation.tool;
            let flange = base * step * nominal * tool;
            let robot = self.external.of_robot(&at);
            let Some(robot) = self.inverse()?.near(&flange, &robot) else { break };
            let next = self.external.whole(&robot, &self.external.others(&at));
            let ends = (desired.translation - real.translation).norm() < ENOUGH
                && rotation_log(&step.rotation).norm() < ENOUGH;
            at = next;
            if ends {
                return Ok(at);
            }
        }
        Err("no joint values were found that reach it".into())
    }

    fn replacement(
        &self,
        point: &Point,
        joints: &[f64],
        flange: &Pose,
        placed: Option<&Placed>,
    ) -> Result<Replacement, String> {
        let Some(placed) = placed else {
            let units = self.units()?;
            let robot = self.external.of_robot(&self.controller(joints));
            let mut numbers: Vec<f64> = robot.iter().zip(&units).map(|(value, unit)| value / unit).collect();
            // Axes that the robot has not stay at zero.
            numbers.resize(point.slots.len().max(numbers.len()), 0.0);
            return Ok(Replacement { numbers, turns: Vec::new() });
        };
        let pose = placed.before.inverse() * *flange * placed.behind;
        let like = self.dialect.orientation().write(&placed.pose.rotation, &point.written_orientation());
        let mut numbers = point.numbers_of(&pose, self.dialect, &like);
        // A place on the way of a circular motion has no angles.
        numbers.truncate(point.slots.len());
        // Data that does not describe the joints is not followed, and stays.
        let turns = match placed.stated {
            true => self.turns(&placed.branch, joints)?,
            false => Vec::new(),
        };
        let turns = if point.turns.len() == turns.len() { turns } else { Vec::new() };
        Ok(Replacement { numbers, turns })
    }

    fn turns(&self, branch: &Branch, joints: &[f64]) -> Result<Vec<i64>, String> {
        let arm = self.arms.all()[self.at].0.chain();
        turns_of(branch, &degrees(arm, &self.external.of_robot(joints)), self.options.turn_axes)
    }
}
