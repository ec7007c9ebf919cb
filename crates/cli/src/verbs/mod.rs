//! The verbs: each reads its files, calls the libraries, prints and writes.

mod check;
mod compare;
mod compensate;
mod completions;
mod criteria;
mod discover;
mod dwell;
mod effects;
mod export;
mod files;
mod fleet;
mod identify;
mod init;
mod iso9283;
mod map;
mod monitor;
mod plan;
mod plan_iso9283;
mod plan_monitor;
mod plan_observed;
mod plan_options;
mod plan_transfer;
mod poses_of_fit;
mod predict;
mod program;
mod repeated;
mod reporting;
mod simulate;
mod sister;
mod stream;
mod template;
mod transfer;
mod verify;

pub use completions::write as completions;

use crate::args::{Accept, Files, Measured, Robot, Verb};
use crate::extensions::effects;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use std::path::Path;
use truepose_compensate::Status;
use truepose_errormodel::{FittedModel, ModelError};
use truepose_io::{CommandStatus, read_fit};
use truepose_kinematics::{Chain, TargetId};
use truepose_workflow::{beyond, usable};

/// Runs a verb.
pub fn run(verb: &Verb, files: &Files, watch: &Watch) -> Result<(), Failure> {
    files::apart(verb, files)?;
    let _locked = files::locked(files)?;
    match verb {
        Verb::Identify(verb) => identify::run(verb, watch),
        Verb::Discover(verb) => discover::run(verb, watch),
        Verb::Plan(verb) => plan::run(verb, watch),
        Verb::Predict(verb) => predict::run(verb, watch),
        Verb::Compensate(of) => match &of.robot_program.program {
            Some(file) => program::run(of, file, &files.read),
            None => compensate::run(of, watch),
        },
        Verb::Export(verb) => export::run(verb),
        Verb::Map(verb) => map::run(verb, watch),
        Verb::Iso9283(verb) => iso9283::run(verb, watch),
        Verb::Transfer(verb) => transfer::run(verb, watch),
        Verb::Fleet(verb) => fleet::run(verb),
        Verb::Monitor(verb) => monitor::run(verb, watch),
        Verb::Compare(verb) => compare::run(verb, watch),
        Verb::Init(verb) => init::run(verb),
        Verb::Dwell(verb) => dwell::run(verb),
        Verb::Check(verb) => check::run(verb),
        Verb::Effects(verb) => effects::run(verb),
        Verb::Simulate(verb) => simulate::run(verb),
        Verb::Verify(verb) => verify::run(verb, watch),
        // Written before anything runs.
        Verb::Completions(_) => Ok(()),
    }
}

/// Reads a robot and passes on what is suspicious about it.
fn robot(args: &Robot) -> Result<Chain, Failure> {
    let (chain, warnings) = args.files().chain()?;
    terminal::warn(&warnings);
    Ok(chain)
}

/// Reads a fit for use as that of a robot, and passes on what is known against it.
fn usable_fit(file: &Path, accepted: &Accept) -> Result<FittedModel, Failure> {
    let fitted = read_fit(file, effects())?;
    terminal::warn(&usable(file, &fitted, accepted.accept)?);
    Ok(fitted)
}

/// The declared target of this name, if the fit knows where it is.
fn target(fitted: &FittedModel, name: Option<&str>) -> Result<Option<TargetId>, Failure> {
    let Some(name) = name else { return Ok(None) };
    let chain = fitted.chain();
    let target = chain.target_named(name).ok_or_else(|| {
        let known: Vec<&str> = chain.targets().iter().map(|target| target.name.as_str()).collect();
        Failure::Input(format!(
            "--target: the robot has no target `{name}` (its targets: {})",
            known.join(", ")
        ))
    })?;
    beyond::seen(fitted, Some(target)).map_err(|words| Failure::Input(format!("--target: {words}")))?;
    Ok(Some(target))
}

/// Files that a run on measurements read.
fn read_files(measured: &Measured) -> Vec<&Path> {
    let Measured { robot, data, model, .. } = measured;
    [Some(&robot.robot), Some(data), model.as_ref()].into_iter().flatten().map(|file| &**file).collect()
}

/// An error about what rows lack, with their file.
fn about(file: &Path) -> impl Fn(ModelError) -> Failure {
    move |error| Failure::Input(format!("{}: {error}", file.display()))
}

/// A value as JSON on stdout.
fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    terminal::print(&(serde_json::to_string_pretty(value)? + "\n"));
    Ok(())
}

/// A summary on stdout, as JSON or in words, and where the result went.
fn told(
    summary: &(impl serde::Serialize + std::fmt::Display),
    json: bool,
    out: &Path,
) -> Result<(), Failure> {
    match json {
        true => print_json(summary)?,
        false => terminal::print(&summary.to_string()),
    }
    terminal::log(&format!("wrote {}", out.display()));
    Ok(())
}

/// A status as files have it.
fn status(status: Status) -> CommandStatus {
    match status {
        Status::Ok => CommandStatus::Ok,
        Status::Unreachable => CommandStatus::Unreachable,
        Status::Limit => CommandStatus::Limit,
        Status::NotConverged => CommandStatus::NotConverged,
    }
}
