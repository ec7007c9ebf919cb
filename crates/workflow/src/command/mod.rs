//! The joint commands that bring the real robot to desired poses.

mod expected;
mod placed;
mod relative;

pub use expected::{CHUNK, CommandOptions, Expected};
pub use placed::Placed;
pub use relative::relative_to;

use crate::beyond;
use crate::error::WorkflowError;
use expected::{expected, for_tools, wanted};
use rayon::prelude::*;
use std::path::Path;
use truepose_compensate::{Command, CommandRequest, CompensateError, Status};
use truepose_errormodel::{FittedModel, History, Signal, history_of, presliding_of};
use truepose_io::Poses;
use truepose_kinematics::Conditions;

/// Poses that are solved together.
const TOGETHER: usize = 64;

/// Joints that stay, by their names.
///
/// # Errors
/// When a joint is not there, or the poses do not state where it is.
pub fn held_joints(fitted: &FittedModel, names: &[String], poses: &Poses) -> Result<Vec<usize>, String> {
    let chain = fitted.chain();
    let place = |name: &String| {
        let found = chain.movable().iter().position(|&id| chain.joint(id).name == *name);
        found.ok_or_else(|| format!("the robot has no joint `{name}` that moves"))
    };
    let all = names.iter().map(place).collect::<Result<Vec<usize>, String>>()?;
    match poses.seeded || all.is_empty() {
        true => Ok(all),
        false => Err("joint columns are needed: they state where joints are that stay".into()),
    }
}

/// Commands for desired poses, in their order, and the expected accuracy of each: that of the nominal robot where it is expected to be more
/// accurate. `begin` is called at each part of them. `fitted` is that of the robot alone ([`FittedModel::of_robot`]).
///
/// # Errors
/// When a signal that the model needs is missing, or the robot has too many joints.
pub fn command(
    fitted: &FittedModel,
    poses: &mut Poses,
    options: &CommandOptions,
    begin: &(dyn Fn() + Sync),
) -> Result<(Vec<Command>, Vec<Expected>), CompensateError> {
    let mut commands = commands(fitted, poses, options, begin)?;
    if winds_up(fitted, poses) {
        // The way of the joints is that of the commands: corrections change it by less than the friction's distance.
        follow(poses, &commands);
        commands = self::commands(fitted, poses, options, begin)?;
    }
    let expected = match options.relative_to {
        Some(other) => relative::expected(fitted, poses, &commands, other)?,
        None => expected(fitted, poses, &mut commands, options)?,
    };
    Ok((commands, expected))
}

/// Whether some effect depends on the way of a joint, and the poses do not state its channel.
fn winds_up(fitted: &FittedModel, poses: &Poses) -> bool {
    let needs = fitted.model().effects().iter().flat_map(|effect| effect.needs());
    needs.into_iter().any(|need| {
        matches!(need, Signal::Channel(name)
            if by_the_way(&name) && poses.rows.schema.channel(&name).is_none())
    })
}

/// Whether a channel of this name is made from the way of a joint.
fn by_the_way(channel: &str) -> bool {
    let history = |history| matches!(history, History::Load(_) | History::Work(_) | History::Travel(_));
    presliding_of(channel).is_some() || history_of(channel).is_some_and(|(what, _)| history(what))
}

/// The joints of the poses as commanded; where there is no command a joint stays where it was.
fn follow(poses: &mut Poses, commands: &[Command]) {
    // Without joint values in the file all rows are one dwell.
    poses.rows.visit = (0..poses.rows.len()).collect();
    for (joint, column) in poses.rows.joints.iter_mut().enumerate() {
        let mut here = column.first().copied().unwrap_or(0.0);
        for (value, command) in column.iter_mut().zip(commands) {
            if command.status == Status::Ok {
                here = command.joints[joint];
            }
            *value = here;
        }
    }
}

/// Warnings about poses of a file whose target or orientation was only declared.
///
/// # Errors
/// When one is unknown to the fit.
pub fn known_poses(fitted: &FittedModel, poses: &Poses, file: &Path) -> Result<Vec<String>, WorkflowError> {
    let refused = |row: usize, words: String| {
        let line = poses.rows.line.get(row).map_or(String::new(), |line| format!("line {line}: "));
        WorkflowError::about(file, WorkflowError::Input(format!("{line}{words}")))
    };
    let (mut warnings, mut done) = (Vec::new(), Vec::new());
    for (row, &target) in poses.rows.target.iter().enumerate() {
        if !done.contains(&target) {
            done.push(target);
            warnings.extend(beyond::seen(fitted, target).map_err(|words| refused(row, words))?);
        }
    }
    if let Some(row) = poses.rows.orientation.iter().position(Option::is_some) {
        warnings.extend(beyond::oriented(fitted).map_err(|words| refused(row, words))?);
    }
    if fitted.domain.joints.is_empty() {
        warnings.push(beyond::NO_RANGE.into());
    }
    Ok(warnings)
}

/// Commands for all poses, in their order; chunks are of fixed size, and no command depends on another.
fn commands(
    fitted: &FittedModel,
    poses: &Poses,
    options: &CommandOptions,
    begin: &(dyn Fn() + Sync),
) -> Result<Vec<Command>, CompensateError> {
    let rows: Vec<usize> = (0..poses.rows.len()).collect();
    let inputs = poses.rows.derived_for(fitted.model())?;
    let compensators = for_tools(fitted, &inputs.schema, options)?;
    // Rows of one tool follow one another.
    let parts: Vec<Vec<Command>> = rows
        .chunk_by(|a, b| inputs.tool(*a) == inputs.tool(*b))
        .flat_map(|rows| rows.chunks(CHUNK))
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|chunk| {
            begin();
            let mut compensator = compensators[inputs.tool(chunk[0]).0].clone();
            let mut conditions = vec![Conditions::default(); TOGETHER];
            let mut commands = Vec::with_capacity(chunk.len());
            for rows in chunk.chunks(TOGETHER) {
                for (conditions, &row) in conditions.iter_mut().zip(rows) {
                    inputs.conditions_into(row, conditions);
                }
                let wanted = |(conditions, &row): (_, &usize)| wanted(poses, conditions, row);
                let wanted: Vec<CommandRequest<'_>> = conditions.iter().zip(rows).map(wanted).collect();
                compensator.commands(&wanted, &mut commands);
            }
            commands
        })
        .collect();
    Ok(parts.concat())
}
