//! `truepose compensate --program`: a robot program with compensated points.

mod places;

use super::joint_units::{in_units, joint_names};
use super::print_json;
use super::reporting::Folder;
use super::sessions::chosen;
use crate::args::{Compensate, GivenPlace, RobotProgram};
use crate::extensions::effects;
use crate::failure::Failure;
use crate::terminal;
use std::path::{Path, PathBuf};
use truepose_controllers::{Correction, Dialect, Outcome, Program, Value, correct};
use truepose_errormodel::FittedModel;
use truepose_io::{CorrectionRow, WholeFiles, check_writable, corrections_file, read_bytes, read_fit};
use truepose_report::{CorrectionView, ProgramView, count, millimetres, program_report};

/// Most lines of points that a message lists.
const LISTED: usize = 20;

/// The file of corrections beside a program.
pub fn table_of(out: &Path) -> PathBuf {
    let mut name = out.as_os_str().to_owned();
    name.push(".corrections.csv");
    name.into()
}

/// What a program is rewritten with.
#[derive(Debug)]
pub(crate) struct Asked<'a> {
    /// The options that only programs have.
    pub own: &'a RobotProgram,
    /// Frames of the program.
    pub frame: &'a [GivenPlace],
    /// Tools of the program.
    pub tcp: &'a [GivenPlace],
    /// File with `[[frames]]` in place of those that the fit has recorded.
    pub frames: Option<&'a Path>,
}

/// A program with compensated points.
#[derive(Debug)]
pub(crate) struct Rewritten {
    /// The program.
    pub text: Vec<u8>,
    /// One for each of its points.
    pub rows: Vec<CorrectionRow>,
    /// The same for pages and JSON.
    pub view: ProgramView,
    /// Lines and words of what cannot be compensated.
    pub refused: Vec<(usize, String)>,
    /// What is to be known of it.
    pub notes: Vec<String>,
}

/// Rewrites the program of a file. `fitted` is that of the robot alone, in one session.
pub(crate) fn rewrite(fitted: &FittedModel, file: &Path, asked: &Asked<'_>) -> Result<Rewritten, Failure> {
    let own = asked.own;
    let about = |file: &Path, error: truepose_controllers::ControllerError| {
        let joint = match error {
            truepose_controllers::ControllerError::Syntax { .. } => ":",
            _ => ": ",
        };
        Failure::Input(format!("{}{joint}{error}", file.display()))
    };
    let dialect = match own.language {
        Some(dialect) => dialect,
        None => Dialect::of_file(file).map_err(|error| about(file, error))?,
    };
    let text = read_bytes(file)?;
    let others: Vec<Vec<u8>> = own.with.iter().map(read_bytes).collect::<Result<_, _>>()?;
    let slices: Vec<&[u8]> = others.iter().map(Vec::as_slice).collect();
    let program = Program::read(&text, &slices, dialect).map_err(|error| about(file, error))?;
    let options = places::options(asked, fitted, &program)?;
    let corrections = correct(&program, fitted, &options).map_err(|error| about(file, error))?;
    let refused = refusals(&program, &corrections);
    if !refused.is_empty() && !own.mark && !own.dry_run {
        return Err(rejected(file, &program, &refused));
    }
    let written = if own.dry_run {
        text.clone()
    } else {
        let new: Vec<_> = corrections.iter().map(|correction| correction.replacement.clone()).collect();
        program.rewritten(&new).map_err(|error| about(file, error))?
    };
    let view = view(file, fitted, &program, &corrections, own.dry_run);
    let (rows, notes) = (rows(&program, &corrections), notes(&program));
    Ok(Rewritten { text: written, rows, view, refused, notes })
}

/// Runs it.
pub fn run(args: &Compensate, file: &Path) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let table = table_of(&args.out);
    check_writable(&table)?;
    let folder = Folder::with_head(args.report.as_ref(), "compensation.json", args.certificate.as_ref())?;
    let fitted = chosen(read_fit(&args.fit, effects())?, args.session.as_deref(), false)?.of_robot();
    let own = &args.robot_program;
    let asked = Asked { own, frame: &args.frame, tcp: &args.tcp, frames: args.frames.as_deref() };
    let Rewritten { text, rows, view, refused, notes } = rewrite(&fitted, file, &asked)?;
    let mut files = WholeFiles::default();
    files.add(&args.out, &text)?;
    files.push(corrections_file(&table, fitted.chain(), &rows)?)?;
    if let Some(folder) = &folder {
        let inputs = [Some(&args.fit), own.program.as_ref(), args.frames.as_ref(), args.certificate.as_ref()];
        let inputs: Vec<&Path> =
            inputs.into_iter().flatten().chain(&own.with).map(PathBuf::as_path).collect();
        folder.add(&mut files, &view, &inputs, |run| Ok(program_report(&view, run)))?;
    }
    files.finish()?;
    if let Some(folder) = &folder {
        terminal::log(&format!("wrote {}", folder.page().display()));
    }
    for line in notes {
        terminal::log(&format!("note: {}:{line}", file.display()));
    }
    if args.json {
        return print_json(&view);
    }
    said(args, &view, &refused);
    Ok(())
}

/// A line for each point and statement that stands against the program.
fn refusals(program: &Program, corrections: &[Correction]) -> Vec<(usize, String)> {
    let mut all: Vec<(usize, String)> = program
        .points()
        .iter()
        .zip(corrections)
        .filter(|(_, correction)| correction.outcome == Outcome::Refused)
        .map(|(point, correction)| (point.line, format!("{}: {}", point.name, correction.reason)))
        .collect();
    let notes = program.notes().iter().filter(|note| note.refuses);
    all.extend(notes.map(|note| (note.line, format!("{}: {}", note.name, note.words))));
    all.sort();
    all.dedup();
    all
}

fn notes(program: &Program) -> Vec<String> {
    let all = program.notes().iter().filter(|note| !note.refuses);
    all.take(LISTED).map(|note| format!("{}: {}: {}", note.line, note.name, note.words)).collect()
}

fn rejected(file: &Path, program: &Program, refused: &[(usize, String)]) -> Failure {
    let mut lines: Vec<String> = refused
        .iter()
        .take(LISTED)
        .map(|(line, words)| format!("{}:{line}: {words}", file.display()))
        .collect();
    if refused.len() > LISTED {
        lines.push(format!("and {} more", refused.len() - LISTED));
    }
    lines.push(format!(
        "nothing is written: {} of {} cannot be compensated. --mark leaves them as they are; --dry-run writes the table alone",
        refused.len(),
        count(program.points().len(), "point")
    ));
    Failure::Input(lines.join("\n"))
}

fn said(args: &Compensate, view: &ProgramView, refused: &[(usize, String)]) {
    let of = |outcome: Outcome| view.points.iter().filter(|point| point.outcome == outcome.word()).count();
    let parts: Vec<String> = [Outcome::Corrected, Outcome::NotSignificant, Outcome::Refused]
        .into_iter()
        .filter(|&outcome| of(outcome) > 0)
        .map(|outcome| format!("{} {}", of(outcome), outcome.word()))
        .collect();
    let what = if args.robot_program.dry_run { "as it is" } else { "compensated" };
    terminal::print(&format!(
        "{}: {}; the program, {what}, is {}, the table {}\n",
        count(view.points.len(), "point"),
        if parts.is_empty() { "none".into() } else { parts.join(", ") },
        args.out.display(),
        table_of(&args.out).display()
    ));
    let largest = view.points.iter().filter_map(|point| point.correction_mm).fold(0.0, f64::max);
    if largest > 0.0 {
        terminal::print(&format!("largest correction: {}\n", millimetres(1e-3 * largest)));
    }
    for (line, words) in refused.iter().take(LISTED) {
        terminal::print(&format!("  unchanged: line {line}: {words}\n"));
    }
    if refused.len() > LISTED {
        terminal::print(&format!("  and {} more\n", refused.len() - LISTED));
    }
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Pose { .. } => "pose",
        Value::Joints(_) => "joints",
    }
}

fn rows(program: &Program, corrections: &[Correction]) -> Vec<CorrectionRow> {
    let one = |(point, correction): (&truepose_controllers::Point, &Correction)| {
        let (frame, tool) = match &point.value {
            Value::Pose { frame, tool, .. } => (frame.words(), tool.words()),
            Value::Joints(_) => (String::new(), String::new()),
        };
        CorrectionRow {
            name: point.name.clone(),
            line: point.line,
            kind: kind(&point.value).into(),
            frame,
            tool,
            outcome: correction.outcome.word().into(),
            reason: correction.reason.clone(),
            desired: correction.desired.unwrap_or([f64::NAN; 3]),
            displacement: correction.displacement.unwrap_or([f64::NAN; 3]),
            rotation: correction.rotation.unwrap_or(f64::NAN),
            within_95: correction.within_95.unwrap_or(f64::NAN),
            nominal: correction.nominal.clone().unwrap_or_default(),
            corrected: correction.corrected.clone().unwrap_or_default(),
        }
    };
    program.points().iter().zip(corrections).map(one).collect()
}

fn view(
    file: &Path,
    fitted: &FittedModel,
    program: &Program,
    corrections: &[Correction],
    dry_run: bool,
) -> ProgramView {
    let chain = fitted.chain();
    let variables = |values: &Vec<f64>| {
        let mut joints = values.clone();
        chain.joints_from_controller(&mut joints);
        in_units(chain, &joints)
    };
    let one = |(point, correction): (&truepose_controllers::Point, &Correction)| {
        let displacement = correction.displacement.map(|d| d.map(|v| 1e3 * v));
        CorrectionView {
            name: point.name.clone(),
            line: point.line,
            kind: kind(&point.value).into(),
            outcome: correction.outcome.word().into(),
            reason: correction.reason.clone(),
            at_mm: correction.desired.map(|place| place.map(|v| 1e3 * v)),
            displacement_mm: displacement,
            correction_mm: displacement.map(|d| d.iter().map(|v| v * v).sum::<f64>().sqrt()),
            rotation_deg: correction.rotation.map(f64::to_degrees),
            within_95_mm: correction.within_95.map(|v| 1e3 * v),
            joints: correction.nominal.as_ref().map(variables),
        }
    };
    let notes =
        program.notes().iter().map(|note| format!("line {}: {}: {}", note.line, note.name, note.words));
    ProgramView {
        robot: chain.name().into(),
        program: file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
        language: program.dialect().word().into(),
        dry_run,
        joints: joint_names(chain),
        notes: notes.collect(),
        points: program.points().iter().zip(corrections).map(one).collect(),
    }
}
