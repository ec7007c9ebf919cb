//! Frames, tools and conditions of a program, from the options.

use super::request::ProgramRequest;
use super::statements::loads;
use super::taught::taught;

use crate::error::WorkflowError;
use crate::parameters::recorded_frames;
use crate::place::{GivenPlace, Place};
use truepose_compensate::installation;
use truepose_controllers::{CorrectOptions, Program};
use truepose_errormodel::FittedModel;
use truepose_io::{FrameParent, NamedFrame, read_details};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{JointKind, Load, Payload, Pose};

struct Places<'a> {
    program: &'a Program,
    frames: Vec<NamedFrame>,
    /// Robot base in the measurement frame.
    base: Pose,
    controller_base: Pose,
    controller_flange: Pose,
}

/// What the options state.
pub(super) fn options(
    request: &ProgramRequest,
    fitted: &FittedModel,
    program: &Program,
    warnings: &mut Vec<String>,
) -> Result<CorrectOptions, WorkflowError> {
    let own = request;
    let places = Places {
        program,
        frames: match request.frames_file.as_deref() {
            Some(file) => read_details(file)?.frames,
            None => recorded_frames(fitted),
        },
        base: installation(fitted)?.base,
        controller_base: own.controller_base.unwrap_or(Pose::IDENTITY),
        controller_flange: own.controller_flange.unwrap_or(Pose::IDENTITY),
    };
    let mut options = CorrectOptions {
        controller_base: places.controller_base,
        controller_flange: places.controller_flange,
        channels: own.channels.clone(),
        limit: own.limit,
        external: own.external.clone(),
        work: own.work.clone(),
        taught: taught(request, fitted, warnings)?,
        stated: own.measured.iter().chain(&own.cad).cloned().collect(),
        ignore_external: own.ignore_external,
        ..CorrectOptions::default()
    };
    for given in &request.frames {
        let pose = places.frame(&given.place)?;
        put("frame", given, pose, &mut options.frames, &mut options.frame)?;
    }
    for given in &request.tools {
        let pose = places.tool(&given.place)?;
        put("tool-frame", given, pose, &mut options.tools, &mut options.tool)?;
    }
    let chain = fitted.chain();
    let unit = |k: usize| match chain.movable().get(k).map(|&joint| chain.joint(joint).kind) {
        Some(JointKind::Prismatic) => 1e-3,
        _ => 1f64.to_radians(),
    };
    let fits = |option: &'static str, have: usize| match have == chain.movable().len() {
        true => Ok(()),
        false => {
            let words = format!("{have} values for {} joints", chain.movable().len());
            Err(WorkflowError::option(option, words))
        }
    };
    if !own.start.is_empty() {
        fits("start", own.start.len())?;
        options.start = Some(own.start.iter().enumerate().map(|(k, value)| value * unit(k)).collect());
    }
    if !own.pulses.is_empty() {
        fits("pulses", own.pulses.len())?;
        if own.pulses.iter().any(|&pulses| !pulses.is_finite() || pulses == 0.0) {
            return Err(WorkflowError::option("pulses", "0 pulses make no angle"));
        }
        options.pulses = Some(own.pulses.iter().enumerate().map(|(k, pulses)| pulses / unit(k)).collect());
    }
    if !own.turn_axes.is_empty() {
        let axes: Result<[usize; 3], _> = own.turn_axes.clone().try_into();
        options.turn_axes =
            Some(axes.map_err(|_| WorkflowError::option("turn-axes", "three axes are needed, as in 1,4,6"))?);
    }
    // Without loads in the data no load has an effect in the model.
    options.program_loads = own.payload.is_none() && loads(fitted).is_some();
    if let Some((mass, com)) = own.payload {
        if !(mass.is_finite() && mass >= 0.0) {
            return Err(WorkflowError::option(
                "payload",
                format!("{mass} is no mass; it has to be 0 or more"),
            ));
        }
        let com = Vector3::from(com);
        options.load = Load::Payload(Payload { mass, com });
    }
    Ok(options)
}

fn put(
    option: &'static str,
    given: &GivenPlace,
    pose: Pose,
    named: &mut Vec<(String, Pose)>,
    any: &mut Option<Pose>,
) -> Result<(), WorkflowError> {
    let twice = match &given.name {
        Some(name) if named.iter().any(|(other, _)| other == name) => true,
        Some(name) => {
            named.push((name.clone(), pose));
            false
        }
        None => any.replace(pose).is_some(),
    };
    match twice {
        true => Err(WorkflowError::option(option, "it is given twice for the same points")),
        false => Ok(()),
    }
}

impl Places<'_> {
    /// A frame in the controller's base.
    fn frame(&self, place: &Place) -> Result<Pose, WorkflowError> {
        let name = match place {
            Place::At(pose) => return Ok(*pose),
            Place::Named(name) => name.as_str(),
        };
        let of_description = |pose: Pose| self.controller_base.inverse() * pose;
        match name {
            "base" => return Ok(Pose::IDENTITY),
            "measurement" => return Ok(of_description(self.base.inverse())),
            _ => {}
        }
        if let Some(found) = self.frames.iter().find(|frame| frame.name == name) {
            return match found.inside {
                FrameParent::Base => Ok(of_description(found.pose)),
                FrameParent::Measurement => Ok(of_description(self.base.inverse() * found.pose)),
                FrameParent::Flange => {
                    let words = format!("`{name}` moves with the robot (in = \"flange\"); it can be a tool");
                    Err(WorkflowError::option("frame", words))
                }
            };
        }
        let root = self.defined("$ROBROOT")?.unwrap_or(Pose::IDENTITY);
        match self.defined(name)? {
            Some(pose) => Ok(root.inverse() * pose),
            None => Err(self.unknown("frame", name)),
        }
    }

    /// A tool in the controller's flange.
    fn tool(&self, place: &Place) -> Result<Pose, WorkflowError> {
        let name = match place {
            Place::At(pose) => return Ok(*pose),
            Place::Named(name) => name.as_str(),
        };
        if name == "flange" {
            return Ok(Pose::IDENTITY);
        }
        if let Some(found) = self.frames.iter().find(|frame| frame.name == name) {
            return match found.inside {
                FrameParent::Flange => Ok(self.controller_flange.inverse() * found.pose),
                _ => {
                    let words = "does not move with the robot; a tool centre point has in = \"flange\"";
                    Err(WorkflowError::option("tool-frame", format!("`{name}` {words}")))
                }
            };
        }
        self.defined(name)?.ok_or_else(|| self.unknown("tool-frame", name))
    }

    fn defined(&self, name: &str) -> Result<Option<Pose>, WorkflowError> {
        self.program.definitions().get(name).map_err(WorkflowError::Input)
    }

    fn unknown(&self, option: &'static str, name: &str) -> WorkflowError {
        let known: Vec<&str> = self.frames.iter().map(|frame| frame.name.as_str()).collect();
        let known = if known.is_empty() { "none".into() } else { known.join(", ") };
        let words = format!(
            "there is no frame `{name}` in the program or the robot file (the robot file's: {known}); write \
             NAME=x,y,z,roll,pitch,yaw for the value of a name of the program"
        );
        WorkflowError::option(option, words)
    }
}
