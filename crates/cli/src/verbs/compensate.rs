//! `truepose compensate`: the joint commands that bring the real robot to desired poses.

pub(crate) use super::expected::Sought;
use super::expected::{CHUNK, Expected, expected, for_tools, wanted};
use super::frames::Placed;
use super::joint_units::{self, in_units, joint_names};
use super::reporting::Folder;
use super::sessions::chosen;
use super::{about, beyond, print_json, relative, status};
use crate::args::Compensate;
use crate::extensions::effects;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::terminal;
use crate::verdict::usable;
use crate::watch::Watch;
use rayon::prelude::*;
use std::path::Path;
use truepose_compensate::{Command, CommandRequest, CompensateError, Status};
use truepose_errormodel::{FittedModel, History, Signal, history_of, presliding_of};
use truepose_io::{
    CommandRow, MeasurementsOptions, PoseForm, Poses, Quantity, WholeFiles, check_writable, commands_file,
    read_fit, read_measurements, read_poses,
};
use truepose_kinematics::{Chain, Conditions, Pose};
use truepose_report::{CommandView, CommandsView, commands_report, count, millimetres};

/// Poses that are solved together.
const TOGETHER: usize = 64;

/// Runs the verb.
pub fn run(args: &Compensate, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let folder = Folder::with_head(args.report.as_ref(), "compensation.json", args.certificate.as_ref())?;
    let fitted = chosen(
        usable(&args.fit, read_fit(&args.fit, effects())?, args.accept.accept)?,
        args.session.as_deref(),
        false,
    )?
    .of_robot();
    let file = file(args);
    let placed = Placed::new(args, &fitted)?;
    let mut poses = read(args, &fitted, &placed)?;
    let mut form = PoseForm::default();
    if let Some(units) = &args.units {
        poses.joint_units = joint_units::chosen(fitted.chain(), &poses.joint_units, units);
        form.length = units.length.unwrap_or(form.length);
        form.turn = poses.convention.zip(units.angle.or(Some(*Quantity::Angle.si())));
    }
    let other =
        args.relative_to.as_ref().map(|tool| relative::other(tool, &fitted, &poses, file)).transpose()?;
    let hold = held(&fitted, &args.hold, &poses)
        .map_err(|words| Failure::Input(format!("--hold: {}: {words}", file.display())))?;
    let sought = Sought { other, lever: placed.lever(), hold };
    let progress = Progress::steps(poses.rows.len().div_ceil(CHUNK), watch);
    let (commands, expected) = commanded(&fitted, &mut poses, &sought, &|| progress.begin("commands"))
        .map_err(|error| match error {
            CompensateError::Model(error) => about(file)(error),
            error => Failure::Input(format!("{}: {error}", args.fit.display())),
        })?;
    drop(progress);
    let channels = poses.rows.derived_for(fitted.model()).map_err(about(file))?.schema.channels.clone();
    let rows: Vec<CommandRow> = commands
        .iter()
        .zip(&expected)
        .map(|(command, expected)| CommandRow {
            joints: command.joints.to_vec(),
            status: status(command.status),
            within_95: expected.within_95,
            corrected: expected.corrected,
            beyond: beyond::words(&expected.beyond, fitted.chain(), &channels),
        })
        .collect();
    let mut files = WholeFiles::default();
    let corrected: Option<Vec<Pose>> = args.cartesian.then(|| {
        let one = |(row, command): (usize, &CommandRow)| {
            placed.corrected(fitted.chain(), &command.joints, &poses, row)
        };
        rows.iter().enumerate().map(one).collect()
    });
    let corrected = corrected.as_deref().map(|poses| (poses, form));
    files.push(commands_file(&args.out, fitted.chain(), &poses, &rows, corrected)?)?;

    let of = |status: Status| commands.iter().filter(|c| c.status == status).count();
    let statuses = [Status::Ok, Status::Limit, Status::Unreachable, Status::NotConverged];
    let mut tally = beyond::Tally::default();
    let ok = commands.iter().zip(&expected).filter(|(command, _)| command.status == Status::Ok);
    ok.clone().for_each(|(_, expected)| tally.add(&expected.beyond));
    tally.warn("command", fitted.chain(), &channels);
    let nominal = ok.clone().filter(|(_, expected)| !expected.corrected).count();
    let unbounded = ok.filter(|(_, expected)| expected.within_95 == f64::INFINITY).count();
    terminal::warn(beyond::unbounded(unbounded, "pose").as_slice());
    if let Some(folder) = &folder {
        let inputs: Vec<&Path> = [
            Some(&args.fit),
            args.poses.as_ref(),
            args.joints.as_ref(),
            args.frames.as_ref(),
            args.certificate.as_ref(),
        ]
        .into_iter()
        .flatten()
        .map(|file| &**file)
        .collect();
        let view = CommandsView {
            robot: fitted.chain().name().into(),
            joints: joint_names(fitted.chain()),
            status: statuses
                .iter()
                .map(|s| (s.word().into(), of(*s)))
                .filter(|s: &(String, usize)| s.1 > 0)
                .collect(),
            extrapolating: tally.beyond(),
            commands: views(fitted.chain(), &poses, &commands, &expected),
        };
        folder.add(&mut files, &view, &inputs, |run| Ok(commands_report(&view, run)))?;
    }
    files.finish()?;
    if let Some(folder) = &folder {
        terminal::log(&format!("wrote {}", folder.page().display()));
    }
    if args.json {
        let counts: serde_json::Map<_, _> =
            statuses.iter().map(|s| (s.word().into(), of(*s).into())).collect();
        return print_json(&serde_json::json!({
            "poses": rows.len(), "status": counts, "extrapolating": tally.beyond(), "nominal": nominal,
            "unbounded": unbounded,
        }));
    }
    let parts: Vec<String> =
        statuses.iter().filter(|s| of(**s) > 0).map(|s| format!("{} {}", of(*s), s.word())).collect();
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
            "largest error of the nearest command for the other poses: {} (these commands are not written)\n",
            millimetres(worst)
        ));
    }
    if nominal > 0 {
        terminal::print(&format!(
            "{} where the correction is smaller than its uncertainty: the command of the nominal robot is written\n",
            count(nominal, "pose")
        ));
    }
    Ok(())
}

/// Joints that stay, by their names.
///
/// # Errors
/// When a joint is not there, or the poses do not state where it is.
pub(crate) fn held(fitted: &FittedModel, names: &[String], poses: &Poses) -> Result<Vec<usize>, String> {
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

/// Commands for desired poses, in their order, and the expected accuracy of each. `begin` is called at each part of them.
pub(crate) fn commanded(
    fitted: &FittedModel,
    poses: &mut Poses,
    sought: &Sought,
    begin: &(dyn Fn() + Sync),
) -> Result<(Vec<Command>, Vec<Expected>), CompensateError> {
    let mut commands = commands(fitted, poses, sought, begin)?;
    if winds_up(fitted, poses) {
        // The way of the joints is that of the commands: corrections change it by less than the friction's distance.
        follow(poses, &commands);
        commands = self::commands(fitted, poses, sought, begin)?;
    }
    let expected = match sought.other {
        Some(other) => relative::expected(fitted, poses, &commands, other)?,
        None => expected(fitted, poses, &mut commands, sought)?,
    };
    Ok((commands, expected))
}

/// The file of poses or joints.
fn file(args: &Compensate) -> &Path {
    args.poses.as_ref().or(args.joints.as_ref()).unwrap_or(&args.fit)
}

/// Desired poses of the measurements' tool, in the measurement frame.
fn read(args: &Compensate, fitted: &FittedModel, placed: &Placed) -> Result<Poses, Failure> {
    let chain = fitted.chain();
    if let Some(joints) = &args.joints {
        let columns = args.named.map_for(fitted);
        let options =
            MeasurementsOptions { measured_required: false, columns, ..MeasurementsOptions::default() };
        let (rows, info, warnings) = read_measurements(joints, chain, &options)?;
        terminal::warn(&warnings);
        return Ok(placed.programme(chain, rows, &info));
    }
    let file = file(args);
    let (mut poses, _, warnings) = read_poses(file, chain, &args.named.map_for(fitted))?;
    terminal::warn(&warnings);
    if !placed.of_the_flange() {
        known(args, fitted, &poses)?;
    }
    placed.place(&mut poses, &file.display().to_string())?;
    let free = poses.rows.orientation.iter().filter(|orientation| orientation.is_none()).count();
    if free > 0 {
        terminal::warn(&[format!(
            "{}: orientation left free in {}: the position alone is held, and the wrist turns as it may",
            file.display(),
            count(free, "pose")
        )]);
    }
    Ok(poses)
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

/// Rejects poses whose target or orientation is unknown to the fit, and warns of those that were only declared.
fn known(args: &Compensate, fitted: &FittedModel, poses: &Poses) -> Result<(), Failure> {
    let refused = |row: usize, words: String| {
        let line = poses.rows.line.get(row).map_or(String::new(), |line| format!("line {line}: "));
        Failure::Input(format!("{}: {line}{words}", file(args).display()))
    };
    let mut done = Vec::new();
    for (row, &target) in poses.rows.target.iter().enumerate() {
        if !done.contains(&target) {
            done.push(target);
            let warning = beyond::seen(fitted, target).map_err(|words| refused(row, words))?;
            terminal::warn(warning.as_slice());
        }
    }
    if let Some(row) = poses.rows.orientation.iter().position(Option::is_some) {
        let warning = beyond::oriented(fitted).map_err(|words| refused(row, words))?;
        terminal::warn(warning.as_slice());
    }
    if fitted.domain.joints.is_empty() {
        terminal::log(
            "warning: the fit does not record the range of its data: extrapolation is not detected",
        );
    }
    Ok(())
}

fn ok(command: &Command) -> bool {
    command.status == Status::Ok
}

/// Commands as page and JSON show them.
fn views(chain: &Chain, poses: &Poses, commands: &[Command], expected: &[Expected]) -> Vec<CommandView> {
    let one = |(row, (command, expected)): (usize, (&Command, &Expected))| CommandView {
        row: row + 1,
        line: poses.rows.line.get(row).copied(),
        status: command.status.word().into(),
        at_mm: (poses.rows.measured_position(row) * 1e3).into(),
        left_mm: command.position_error * 1e3,
        correction_mm: ok(command).then_some(expected.correction * 1e3),
        within_95_mm: beyond::bounded(expected.within_95).filter(|_| ok(command)).map(|within| within * 1e3),
        extrapolates: ok(command).then_some(!expected.beyond.is_empty()),
        joints: ok(command).then(|| in_units(chain, &command.joints)),
    };
    commands.iter().zip(expected).enumerate().map(one).collect()
}

/// Commands for all poses, in their order; chunks are of fixed size, and no command depends on another.
fn commands(
    fitted: &FittedModel,
    poses: &Poses,
    sought: &Sought,
    begin: &(dyn Fn() + Sync),
) -> Result<Vec<Command>, CompensateError> {
    let rows: Vec<usize> = (0..poses.rows.len()).collect();
    let inputs = poses.rows.derived_for(fitted.model())?;
    let compensators = for_tools(fitted, &inputs.schema, sought)?;
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
