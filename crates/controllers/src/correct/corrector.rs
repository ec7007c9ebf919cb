//! The correction of one point.

use super::before::{Before, Open, Travel};
use super::configuration::{degrees, turns_of};
use super::correction::Correction;
use super::external::{Arms, External};
use super::frames::Frames;
use super::inverse::{Inverse, NOT_KNOWN};
use super::options::CorrectOptions;
use super::placed::{Placed, Stays};
use super::signals::signals;
use super::taught::Learned;
use super::work::Work;
use crate::definitions::Definitions;
use crate::program::{Branch, Point, Program, Replacement, Value};
use crate::{ControllerError, Dialect};
use truepose_compensate::{Compensator, CompensatorOptions, Installation, installation_of};
use truepose_errormodel::{Channel, Coverage, FittedModel, Predictor};
use truepose_kinematics::nalgebra::Matrix3;
use truepose_kinematics::{Chain, Conditions, JointKind, Pose, ToolId};

/// What places the robot, its tools and its work.
#[derive(Debug)]
pub(super) struct Placing {
    pub(super) external: External,
    pub(super) arms: Arms,
    pub(super) learned: Learned,
    pub(super) work: Work,
}

/// Corrects the points of one program.
pub(super) struct Corrector<'m> {
    pub(super) dialect: Dialect,
    pub(super) definitions: &'m Definitions,
    pub(super) fitted: &'m FittedModel,
    pub(super) chain: &'m Chain,
    pub(super) options: &'m CorrectOptions,
    pub(super) installation: Installation,
    pub(super) noise: Matrix3<f64>,
    pub(super) frames: Frames<'m>,
    pub(super) learned: &'m Learned,
    pub(super) external: &'m External,
    pub(super) arms: &'m Arms,
    pub(super) work: &'m Work,
    /// Of each arm that was needed.
    pub(super) inverses: Vec<Option<Inverse<'m>>>,
    /// The arm of the point.
    pub(super) at: usize,
    pub(super) real: Compensator<'m>,
    pub(super) coverage: Coverage<'m>,
    /// For what a desired position leans on.
    pub(super) predictor: Predictor<'m>,
    pub(super) conditions: Conditions,
    pub(super) channels: Vec<Channel>,
}

impl<'m> Corrector<'m> {
    pub(super) fn new(
        program: &'m Program,
        fitted: &'m FittedModel,
        placing: &'m Placing,
        options: &'m CorrectOptions,
    ) -> Result<Self, ControllerError> {
        let Placing { external, arms, learned, work } = placing;
        let chain = fitted.chain();
        if options.turn_axes.is_some_and(|axes| axes.iter().any(|axis| !(1..=6).contains(axis))) {
            return Err(ControllerError::Option("the axes of turn numbers are 1 to 6".into()));
        }
        let stated = options.pulses.as_deref().zip(program.definitions().pulses_per_degree());
        stated.map_or(Ok(()), |(stated, known)| alike(stated, known)).map_err(ControllerError::Option)?;
        let (schema, values) = signals(fitted, options)?;
        let mut conditions = Conditions::at(chain, &vec![0.0; chain.movable().len()]).with_load(options.load);
        conditions.channels = values;
        conditions.tool = external.hand;
        let search = CompensatorOptions {
            tool: external.hand,
            hold: external.places(),
            ..CompensatorOptions::default()
        };
        Ok(Corrector {
            dialect: program.dialect,
            definitions: program.definitions(),
            fitted,
            chain,
            options,
            installation: installation_of(fitted, external.hand)?,
            noise: Matrix3::identity() * fitted.noise.position_sd.powi(2),
            frames: Frames::new(program, options)?,
            learned,
            external,
            arms,
            work,
            inverses: arms.all().iter().map(|_| None).collect(),
            at: 0,
            real: Compensator::bind(fitted, &schema, search)?,
            coverage: Coverage::new(fitted, &schema)?,
            predictor: fitted.bind(&schema)?,
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
        if let Err(Stays { outcome, reason }) = self.judged(point, &joints, placed, &mut correction) {
            correction.outcome = outcome;
            correction.reason = reason;
            correction.replacement = None;
        }
        (correction, Ok(joints))
    }

    pub(super) fn controller(&self, joints: &[f64]) -> Vec<f64> {
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
                let on = self.work.of(names.0);
                let frame =
                    if on.is_some() { self.frames.carried(frame)? } else { self.frames.frame(frame)? };
                let tool = self.frames.tool(tool)?;
                let real = (self.learned.frame(names.0, frame), self.learned.tool(names.1, tool));
                let (base, flange) = (self.options.controller_base, self.options.controller_flange);
                let base = on.map_or(base, |on| self.nominal(on, &values));
                let mut placed = Placed {
                    pose: *pose,
                    before: base * frame,
                    behind: flange * tool,
                    real: [base * real.0, flange * real.1],
                    on: on.map(|on| (on, frame)),
                    branch: branch.clone(),
                    stated: false,
                };
                // The arm of the search is where its external axes are at zero.
                let flange = self.external.shift(self.chain, &values).inverse() * placed.flange();
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
        let place = self.arms.place(self.external, values);
        self.at = place.ok_or("the robot is no single arm, of which external axes could be held")?;
        if self.inverses[self.at].is_none() {
            let (ideal, unlimited) = &self.arms.all()[self.at];
            let new = Inverse::new(ideal, unlimited.as_ref(), self.options.turn_axes);
            self.inverses[self.at] = Some(new.map_err(|error| error.to_string())?);
        }
        Ok(())
    }

    pub(super) fn inverse(&mut self) -> Result<&mut Inverse<'m>, String> {
        self.inverses[self.at].as_mut().ok_or_else(|| "the arm is not known".into())
    }

    /// Units of the axes of joint points, rad or m.
    fn units(&self) -> Result<Vec<f64>, String> {
        let movable: Vec<_> = self.external.robot.iter().map(|&k| self.chain.movable()[k]).collect();
        if self.dialect == Dialect::Inform {
            let Some(pulses) = &self.options.pulses else {
                return Err(match self.definitions.pulses_per_degree() {
                    None => "it is in pulses, and how many make a degree is not known (--pulses)".into(),
                    Some(known) => format!(
                        "it is in pulses; by the controller's parameters {} make a degree, their signs are not stated: give them as the joints of the fit \
                         turn (--pulses)",
                        known.iter().map(|pulses| format!("{pulses:.3}")).collect::<Vec<_>>().join(",")
                    ),
                });
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

    pub(super) fn flange(&self, joints: &[f64]) -> Pose {
        let (chain, hand) = (self.chain, self.external.hand);
        let tool = chain.tools()[hand.0].placed.pose;
        chain.base().pose.inverse() * chain.forward_to(hand, joints) * tool.inverse()
    }

    /// A nominal tool that the external axes alone carry, in the base of the description.
    fn nominal(&self, tool: ToolId, values: &[f64]) -> Pose {
        let joints = self.external.whole(&vec![0.0; self.external.robot.len()], values);
        self.chain.base().pose.inverse() * self.chain.forward_to(tool, &joints)
    }

    pub(super) fn replacement(
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

/// Whether pulses per rad that were stated are those of the controller's parameters, per degree and without sign.
fn alike(stated: &[f64], known: &[f64]) -> Result<(), String> {
    /// Of their size.
    const DIGITS: f64 = 1e-3;
    let each = stated.iter().map(|pulses| pulses.to_radians().abs()).zip(known);
    let unlike = (1..).zip(each).find(|(_, (stated, known))| (stated - *known).abs() > DIGITS * *known);
    unlike.map_or(Ok(()), |(axis, (stated, known))| {
        Err(format!(
            "axis {axis} has {stated:.3} pulses per degree as stated, {known:.3} by the controller's parameters: the one or the other is of another robot"
        ))
    })
}
