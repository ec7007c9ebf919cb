//! `truepose compensate`: the joint commands that bring the real robot to desired poses.

use super::reporting::Folder;
use super::{about, print_json, status, usable_fit};
use crate::args::Compensate;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::terminal;
use crate::watch::Watch;
use std::path::Path;
use truepose_compensate::{Command, CompensateError, Status};
use truepose_errormodel::FittedModel;
use truepose_io::{
    CommandRow, MeasurementsOptions, PoseForm, Poses, Quantity, WholeFiles, check_writable, commands_file,
    read_measurements, read_poses,
};
use truepose_kinematics::{Chain, Pose};
use truepose_report::{CommandView, CommandsView, commands_report, count, millimetres};
use truepose_workflow::command::{
    CHUNK, CommandOptions, Expected, Placed, command, held_joints, known_poses, relative_to,
};
use truepose_workflow::joint_units::{self, in_units, joint_names};
use truepose_workflow::{beyond, in_session};

/// Runs the verb.
pub fn run(args: &Compensate, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let folder = Folder::with_head(args.report.as_ref(), "compensation.json", args.certificate.as_ref())?;
    let fitted = usable_fit(&args.fit, &args.accept)?;
    let fitted = in_session(fitted, args.session.as_deref(), false)?.of_robot();
    let file = file(args);
    let placed = Placed::new([&args.frame, &args.tcp], args.frames.as_deref(), &fitted)?;
    let mut poses = read(args, &fitted, &placed)?;
    let mut form = PoseForm::default();
    if let Some(units) = &args.units {
        poses.joint_units = joint_units::chosen(fitted.chain(), &poses.joint_units, units);
        form.length = units.length.unwrap_or(form.length);
        form.turn = poses.convention.zip(units.angle.or(Some(*Quantity::Angle.si())));
    }
    let other = args.relative_to.as_ref().map(|tool| relative_to(tool, &fitted, &poses, file)).transpose()?;
    terminal::warn(other.iter().flat_map(|(_, warning)| warning).collect::<Vec<_>>().as_slice());
    let hold = held_joints(&fitted, &args.hold, &poses)
        .map_err(|words| Failure::Input(format!("--hold: {}: {words}", file.display())))?;
    let relative_to = other.map(|(tool, _)| tool);
    let options = CommandOptions { relative_to, lever: placed.lever(), hold };
    let progress = Progress::steps(poses.rows.len().div_ceil(CHUNK), watch);
    let (commands, expected) = command(&fitted, &mut poses, &options, &|| progress.begin("commands"))
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
    terminal::warn(tally.warning("command", fitted.chain(), &channels).as_slice());
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
        terminal::warn(&known_poses(fitted, &poses, file)?);
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
