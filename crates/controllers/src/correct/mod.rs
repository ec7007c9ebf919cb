//! What becomes of each point.
//!
//! ```text
//! pose P in frame F of tool X      nominal flange  K · F · P · X⁻¹ · G⁻¹
//! joints q                         nominal flange  A(q)
//! desired tool of the measurements B E_0 · flange · tool E_tool                command q' of the real robot
//! replaced by                      F⁻¹ · K⁻¹ · A(q') · G · X,  or  q'
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | K, G | `controller_base`, `controller_flange` | m | description's base; last joint |
//! | B E_0, tool E_tool | [`Installation`] | m | measurement; last joint |
//! | A | the nominal joints alone | m | description's base |
//!
//! A point near a singularity is refused, see `singular`.

mod configuration;
mod correction;
mod frames;
mod inverse;
mod options;
mod outside;
mod signals;
mod singular;

pub use correction::{Correction, Outcome};
pub use options::CorrectOptions;

use crate::program::{Branch, Point, Program, Replacement, Step, Value};
use crate::{ControllerError, Dialect};
use configuration::{degrees, turns_of};
use frames::Frames;
use inverse::Inverse;
use outside::outside;
use signals::signals;
use singular::singular;
use truepose_compensate::{
    Compensator, CompensatorOptions, Installation, Status, Target, correction_helps, installation, radius_95,
};
use truepose_errormodel::{Channel, Coverage, ErrorModel, FittedModel};
use truepose_kinematics::nalgebra::{DMatrix, Matrix3};
use truepose_kinematics::{Chain, Conditions, JointKind, Pose, PostureBuffer, rotation_log};

/// Corrects all points of a program; one correction for each, in their order.
///
/// # Errors
/// When the fit or the options do not fit the program; a point that cannot be corrected is no error but refused.
pub fn correct(
    program: &Program,
    fitted: &FittedModel,
    options: &CorrectOptions,
) -> Result<Vec<Correction>, ControllerError> {
    let all = correct_all(std::slice::from_ref(program), fitted, options)?;
    Ok(all.into_iter().flatten().collect())
}

/// Corrects all points of the files of a program ([`Program::read_all`]); a list for each file.
///
/// # Errors
/// As [`correct`]; a frame or tool of the options has to be one of some file.
pub fn correct_all(
    programs: &[Program],
    fitted: &FittedModel,
    options: &CorrectOptions,
) -> Result<Vec<Vec<Correction>>, ControllerError> {
    frames::named(programs, options)?;
    let ideal = FittedModel::new(
        ErrorModel::new(fitted.chain().clone(), Vec::new())?,
        Vec::new(),
        DMatrix::zeros(0, 0),
    )?;
    programs.iter().map(|program| one_file(program, fitted, &ideal, options)).collect()
}

fn one_file(
    program: &Program,
    fitted: &FittedModel,
    ideal: &FittedModel,
    options: &CorrectOptions,
) -> Result<Vec<Correction>, ControllerError> {
    let mut corrector = Corrector::new(program, fitted, ideal, options)?;
    let mut done: Vec<Option<Correction>> = vec![None; program.points.len()];
    let mut joints: Vec<Option<Vec<f64>>> = vec![None; program.points.len()];
    let start = corrector.start()?;
    let mut before = start.clone().map(|joints| (joints, None));
    for step in &program.order {
        let Step::Point(k) = *step else {
            before = None;
            continue;
        };
        if done[k].is_none() {
            let (correction, at) = corrector.point(&program.points[k], before.as_ref());
            (done[k], joints[k]) = (Some(correction), at);
        }
        before = joints[k].clone().map(|joints| (joints, opaque(&program.points[k])));
    }
    let start = start.map(|joints| (joints, None));
    let mut all = Vec::with_capacity(done.len());
    for (point, correction) in program.points.iter().zip(done) {
        all.push(correction.unwrap_or_else(|| corrector.point(point, start.as_ref()).0));
    }
    Ok(all)
}

/// Joints of the point before (variables), and its configuration data where that is not interpreted.
type Before = (Vec<f64>, Option<String>);

fn opaque(point: &Point) -> Option<String> {
    match &point.value {
        Value::Pose { branch: Branch::Opaque(words), .. } => Some(words.clone()),
        _ => None,
    }
}

struct Corrector<'m> {
    dialect: Dialect,
    fitted: &'m FittedModel,
    chain: &'m Chain,
    options: &'m CorrectOptions,
    installation: Installation,
    noise: Matrix3<f64>,
    frames: Frames<'m>,
    inverse: Inverse<'m>,
    real: Compensator<'m>,
    coverage: Coverage<'m>,
    conditions: Conditions,
    channels: Vec<Channel>,
    buffer: PostureBuffer,
}

/// A pose of the program with what it is in.
struct Placed {
    pose: Pose,
    /// `K · F`.
    before: Pose,
    /// `G · X`.
    behind: Pose,
    branch: Branch,
}

impl<'m> Corrector<'m> {
    fn new(
        program: &'m Program,
        fitted: &'m FittedModel,
        ideal: &'m FittedModel,
        options: &'m CorrectOptions,
    ) -> Result<Self, ControllerError> {
        let chain = fitted.chain();
        if options.turn_axes.is_some_and(|axes| axes.iter().any(|axis| !(1..=6).contains(axis))) {
            return Err(ControllerError::Option("the axes of turn numbers are 1 to 6".into()));
        }
        if let Some(mimic) = chain.mimics().first() {
            let (joint, driver) = (&chain.joint(mimic.joint).name, &chain.joint(mimic.driver).name);
            let words = format!(
                "joint {joint} follows {driver}, which no program of a controller can say; use `compensate --poses`"
            );
            return Err(ControllerError::Fit(words));
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
            inverse: Inverse::new(ideal, options.turn_axes)?,
            real: Compensator::bind(fitted, &schema, CompensatorOptions::default())?,
            coverage: Coverage::new(fitted, &schema)?,
            conditions,
            channels: schema.channels,
            buffer: PostureBuffer::new(chain),
        })
    }

    /// The joints before the program, as variables.
    fn start(&self) -> Result<Option<Vec<f64>>, ControllerError> {
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
    fn point(&mut self, point: &Point, before: Option<&Before>) -> (Correction, Option<Vec<f64>>) {
        let located = self.located(point, before);
        let (joints, placed) = match located {
            Ok(located) => located,
            Err(reason) => return (Correction::refused(reason), None),
        };
        let mut correction = Correction::refused(String::new());
        correction.nominal = Some(self.controller(&joints));
        if let Err(reason) = self.judged(point, &joints, placed.as_ref(), &mut correction) {
            correction.outcome = Outcome::Refused;
            correction.reason = reason;
            correction.replacement = None;
        }
        (correction, Some(joints))
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
        before: Option<&Before>,
    ) -> Result<(Vec<f64>, Option<Placed>), String> {
        if let Some(reason) = &point.fixed {
            return Err(reason.clone());
        }
        if let Some((name, value)) = point.external.first().filter(|_| !self.options.ignore_external) {
            return Err(format!(
                "external axis {name} is at {value}: whether it moves the robot or its work is not known (--ignore-external)"
            ));
        }
        match &point.value {
            Value::Joints(values) => Ok((self.variables(values)?, None)),
            Value::Pose { pose, frame, tool, branch } => {
                if let (Branch::Opaque(words), Some((_, Some(other)))) = (branch, before)
                    && words != other
                {
                    return Err(format!(
                        "its configuration ({words}) is not that of the point before ({other}), and is not interpreted: put a point in \
                         joint values before it"
                    ));
                }
                let frame = self.frames.frame(frame)?;
                let tool = self.frames.tool(tool)?;
                let placed = Placed {
                    pose: *pose,
                    before: self.options.controller_base * frame,
                    behind: self.options.controller_flange * tool,
                    branch: branch.clone(),
                };
                let flange = placed.before * placed.pose * placed.behind.inverse();
                let joints =
                    self.inverse.joints(&flange, branch, before.map(|(joints, _)| joints.as_slice()))?;
                Ok((joints, Some(placed)))
            }
        }
    }

    /// Units of the axes of joint points, rad or m.
    fn units(&self) -> Result<Vec<f64>, String> {
        let movable = self.chain.movable();
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

    /// Variables of a joint point.
    fn variables(&self, values: &[f64]) -> Result<Vec<f64>, String> {
        let units = self.units()?;
        if values.len() < units.len() || values[units.len()..].iter().any(|&value| value != 0.0) {
            return Err(format!("it has {} axes, the robot {}", values.len(), units.len()));
        }
        let mut joints: Vec<f64> = values.iter().zip(&units).map(|(value, unit)| value * unit).collect();
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
    ) -> Result<(), String> {
        let flange = match placed {
            Some(placed) => placed.before * placed.pose * placed.behind.inverse(),
            None => self.flange(joints),
        };
        let desired = self.installation.base * flange * self.installation.tool;
        correction.desired = Some(desired.translation.into());
        self.conditions.joints = joints.to_vec();
        let here = self.coverage.judge(&self.conditions, None);
        let oriented = joints.len() >= 6;
        outside(self.fitted, &self.channels, &self.conditions, &here.beyond)?;
        let error = here.pose.translation - desired.translation;
        if !correction_helps(&error, &here.covariance) {
            correction.outcome = Outcome::NotSignificant;
            correction.reason = "the correction is smaller than its uncertainty".into();
            let reach = radius_95(&(here.covariance + self.noise));
            correction.within_95 = Some(reach + error.norm());
            return Ok(());
        }
        // Where a joint has no effect of its own, no search finds anything.
        singular(self.chain, &mut self.buffer, joints, joints)?;
        let mut target = Target::at(desired.translation);
        target.orientation = oriented.then_some(desired.rotation);
        let command = self.real.command(&target, &self.conditions, Some(joints));
        match command.status {
            Status::Ok => {}
            Status::Limit => return Err("only joint values beyond their limits would reach it".into()),
            Status::Unreachable => return Err("the real robot does not reach it".into()),
            Status::NotConverged => return Err("no joint values were found that reach it".into()),
        }
        singular(self.chain, &mut self.buffer, joints, &command.joints)?;
        self.conditions.joints = command.joints.to_vec();
        let there = self.coverage.judge(&self.conditions, None);
        outside(self.fitted, &self.channels, &self.conditions, &there.beyond)?;
        correction.within_95 = Some(radius_95(&(there.covariance + self.noise)));
        let branch = placed.map_or(&Branch::Continuous, |placed| &placed.branch);
        if !self.inverse.same(joints, &command.joints, branch) {
            return Err(
                "the correction changes the arm's configuration: the point is at a singularity".into()
            );
        }
        let new = self.flange(&command.joints);
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
        correction.corrected = Some(self.controller(&command.joints));
        if moved.0.norm() > self.options.limit {
            return Err(format!(
                "the correction of {:.3} mm is above the limit of {:.3} mm",
                1e3 * moved.0.norm(),
                1e3 * self.options.limit
            ));
        }
        correction.replacement = Some(self.replacement(point, &command.joints, &new, placed)?);
        correction.outcome = Outcome::Corrected;
        Ok(())
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
            let mut numbers: Vec<f64> =
                self.controller(joints).iter().zip(&units).map(|(value, unit)| value / unit).collect();
            // Axes that the robot has not stay at zero.
            numbers.resize(point.slots.len().max(numbers.len()), 0.0);
            return Ok(Replacement { numbers, turns: Vec::new() });
        };
        let pose = placed.before.inverse() * *flange * placed.behind;
        let like = self.dialect.orientation().write(&placed.pose.rotation, &point.written_orientation());
        let numbers = point.numbers_of(&pose, self.dialect, &like);
        let turns = turns_of(&placed.branch, &degrees(self.chain, joints), self.options.turn_axes)?;
        let turns = if point.turns.len() == turns.len() { turns } else { Vec::new() };
        Ok(Replacement { numbers, turns })
    }
}
