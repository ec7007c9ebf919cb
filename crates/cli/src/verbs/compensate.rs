//! `truepose compensate`: the joint commands that bring the real robot to desired poses.

use super::reporting::Folder;
use super::{about, print_json, status};
use crate::args::Compensate;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::terminal;
use rayon::prelude::*;
use truepose_compensate::{
    Command, CompensateError, Compensator, CompensatorOptions, Status, Target, Wanted, predicted_error,
};
use truepose_errormodel::{EffectRegistry, FittedModel};
use truepose_io::{CommandRow, Poses, check_writable, read_fit, read_poses, write_commands};
use truepose_kinematics::Conditions;
use truepose_report::{CommandView, CommandsView, commands_report, count, millimetres};

/// Poses that one thread takes at a time.
const CHUNK: usize = 2048;
/// Of which so many are asked together.
const TOGETHER: usize = 64;

/// Runs the verb.
pub fn run(args: &Compensate) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let folder = Folder::prepare(args.report.as_ref(), "compensation.json")?;
    let fitted = read_fit(&args.fit, &EffectRegistry::builtin())?;
    let (poses, _, warnings) = read_poses(&args.poses, fitted.chain())?;
    terminal::warn(&warnings);
    let commands = commands(args, &fitted, &poses)?;
    let rows: Vec<CommandRow> =
        commands.iter().map(|c| CommandRow { joints: c.joints.to_vec(), status: status(c.status) }).collect();
    write_commands(&args.out, fitted.chain(), &poses, &rows)?;

    let of = |status: Status| commands.iter().filter(|c| c.status == status).count();
    let words = [Status::Ok, Status::Limit, Status::Unreachable, Status::NotConverged];
    let beyond = commands.iter().filter(|c| c.status == Status::Ok && c.extrapolation.any()).count();
    if let Some(folder) = &folder {
        let view = CommandsView {
            robot: fitted.chain().name().into(),
            status: words
                .iter()
                .map(|s| (s.word().into(), of(*s)))
                .filter(|s: &(String, usize)| s.1 > 0)
                .collect(),
            extrapolating: beyond,
            commands: views(&fitted, &poses, &commands)?,
        };
        folder.write(&view, &[&args.fit, &args.poses], |run| Ok(commands_report(&view, run)))?;
    }
    if args.json {
        let counts: serde_json::Map<_, _> = words.iter().map(|s| (s.word().into(), of(*s).into())).collect();
        return print_json(
            &serde_json::json!({"poses": rows.len(), "status": counts, "extrapolating": beyond}),
        );
    }
    let parts: Vec<String> =
        words.iter().filter(|s| of(**s) > 0).map(|s| format!("{} {}", of(*s), s.word())).collect();
    terminal::print(&format!(
        "{}: {}; written to {}\n",
        count(rows.len(), "pose"),
        parts.join(", "),
        args.out.display()
    ));
    let worst =
        commands.iter().filter(|c| c.status != Status::Ok).map(|c| c.position_error).fold(0.0, f64::max);
    if worst > 0.0 {
        terminal::print(&format!(
            "the nearest that was found for the others is up to {} off\n",
            millimetres(worst)
        ));
    }
    if beyond > 0 {
        terminal::print(&format!(
            "{} outside the range that the model was fitted on: it extrapolates there\n",
            count(beyond, "command")
        ));
    }
    Ok(())
}

/// What the page and its JSON have of every command.
fn views(fitted: &FittedModel, poses: &Poses, commands: &[Command]) -> Result<Vec<CommandView>, Failure> {
    let inputs = poses.rows.derived_for(fitted.model())?;
    let mut predictor = fitted.bind(&inputs.schema)?;
    let mut conditions = Conditions::default();
    let one = |(row, command): (usize, &Command)| {
        inputs.conditions_into(row, &mut conditions);
        conditions.joints.clear();
        conditions.joints.extend_from_slice(&command.joints);
        let target = poses.rows.target[row];
        let wanted = poses.rows.measured_position(row);
        let nominal = predictor.nominal(&conditions, target).translation;
        CommandView {
            row: row + 1,
            status: command.status.word().into(),
            at_mm: (wanted * 1e3).into(),
            left_mm: command.position_error * 1e3,
            correction_mm: (nominal - wanted).norm() * 1e3,
            within_95_mm: predicted_error(fitted, &mut predictor, &conditions, target).measured_95 * 1e3,
            extrapolates: command.extrapolation.any(),
        }
    };
    Ok(commands.iter().enumerate().map(one).collect())
}

/// What is asked of one row.
fn wanted<'a>(poses: &Poses, conditions: &'a Conditions, row: usize) -> Wanted<'a> {
    let mut target = Target::at(poses.rows.measured_position(row)).of(poses.rows.target[row]);
    target.orientation = poses.rows.measured_rotation(row);
    Wanted { target, conditions, seed: poses.seeded.then_some(conditions.joints.as_slice()) }
}

/// Commands for all poses, in their order; chunks are of fixed size, and no command depends on another.
fn commands(args: &Compensate, fitted: &FittedModel, poses: &Poses) -> Result<Vec<Command>, Failure> {
    let rows: Vec<usize> = (0..poses.rows.len()).collect();
    let inputs = poses.rows.derived_for(fitted.model()).map_err(about(&args.poses))?;
    let compensator = Compensator::bind(fitted, &inputs.schema, CompensatorOptions::default()).map_err(
        |error| match error {
            CompensateError::Model(error) => about(&args.poses)(error),
            error => Failure::Input(format!("{}: {error}", args.fit.display())),
        },
    )?;
    let progress = Progress::steps(rows.len().div_ceil(CHUNK));
    let parts: Vec<Vec<Command>> = rows
        .par_chunks(CHUNK)
        .map(|chunk| {
            progress.begin("commands");
            let mut compensator = compensator.clone();
            let mut conditions = vec![Conditions::default(); TOGETHER];
            let mut commands = Vec::with_capacity(chunk.len());
            for rows in chunk.chunks(TOGETHER) {
                for (conditions, &row) in conditions.iter_mut().zip(rows) {
                    inputs.conditions_into(row, conditions);
                }
                let wanted = |(conditions, &row): (_, &usize)| wanted(poses, conditions, row);
                let wanted: Vec<Wanted<'_>> = conditions.iter().zip(rows).map(wanted).collect();
                compensator.commands(&wanted, &mut commands);
            }
            commands
        })
        .collect();
    Ok(parts.concat())
}
