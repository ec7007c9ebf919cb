//! The files of a robot program with compensated points.

use super::request::{Files, ProgramRequest};
use super::rows::{Labels, Part, rows, short, view};
use super::{LISTED, places, statements, taught};
use crate::error::WorkflowError;
use std::path::{Path, PathBuf};
use truepose_controllers::{
    ControllerError, Correction, Dialect, Gathered, Outcome, Program, correct_all, gathered, unused,
};
use truepose_errormodel::FittedModel;
use truepose_io::{CorrectionRow, OffsetRow, read_bytes};
use truepose_report::{ProgramView, changed_lines, count};

/// One file of a program with compensated points.
#[derive(Debug)]
pub struct RewrittenFile {
    /// Where it was read.
    pub file: PathBuf,
    /// Its new text.
    pub text: Vec<u8>,
    /// One for each of its points.
    pub rows: Vec<CorrectionRow>,
}

/// A program with compensated points.
#[derive(Debug, Default)]
pub struct Rewritten {
    /// The program, then the further files that have points of it.
    pub files: Vec<RewrittenFile>,
    /// All points for pages and JSON.
    pub view: ProgramView,
    /// What cannot be compensated: file, line and words.
    pub refused: Vec<(PathBuf, usize, String)>,
    /// What is to be known of it.
    pub notes: Vec<String>,
    /// What is suspicious about files that were read for it.
    pub warnings: Vec<String>,
    /// Names of options that it does not have, and in words.
    pub unused: Vec<(String, String)>,
    /// Its points by what other value of a frame or a tool would correct them, where that is wanted.
    pub gathered: Gathered,
    /// Of each of its files those points.
    pub labels: Vec<Labels>,
    /// The corrections as other values of frames and tools, likewise.
    pub offsets: Vec<OffsetRow>,
}

/// Rewrites the files of a program; none where no point has a value.
pub(super) fn rewritten(
    fitted: &FittedModel,
    files: &Files<'_>,
    request: &ProgramRequest,
) -> Result<Option<Rewritten>, WorkflowError> {
    let own = request;
    let file = files.own[0];
    let about = |file: &Path, error: ControllerError| {
        let joint = match error {
            ControllerError::Syntax { .. } => ":",
            _ => ": ",
        };
        WorkflowError::Input(format!("{}{joint}{error}", file.display()))
    };
    let dialect = match own.language {
        Some(dialect) => dialect,
        None => Dialect::of_file(file).map_err(|error| about(file, error))?,
    };
    let paths: Vec<&Path> = files.own.iter().chain(&files.tables).copied().collect();
    let texts: Vec<Vec<u8>> = paths.iter().map(read_bytes).collect::<Result<_, _>>()?;
    let slices: Vec<&[u8]> = texts.iter().map(Vec::as_slice).collect();
    let programs = Program::read_all(&slices, dialect).map_err(|(k, error)| about(paths[k], error))?;
    let mut warnings = Vec::new();
    let options = places::options(request, fitted, &programs[0], &mut warnings)?;
    let mut corrections = correct_all(&programs, fitted, &options).map_err(|error| about(file, error))?;
    // Of further files those points alone to which a motion goes: others are other programs'.
    let taken: Vec<Vec<bool>> = programs
        .iter()
        .enumerate()
        .map(|(k, program)| match k {
            0 => vec![true; program.points().len()],
            _ if k < files.own.len() => program.reached(),
            _ => vec![false; program.points().len()],
        })
        .collect();
    let mut unused = unused(&programs, &options);
    unused.extend(leave(&own.leave, &programs, &mut corrections));
    let parts: Vec<Part<'_>> = (0..files.own.len())
        .map(|k| Part { file: paths[k], program: &programs[k], corrections: &corrections[k], own: &taken[k] })
        .collect();
    let refused = refusals(&parts, &own.leave);
    if !refused.is_empty() && !own.mark && !own.dry_run {
        return Err(rejected(&parts, &refused, &unused));
    }
    if !own.dry_run && !taken.iter().flatten().any(|own| *own) {
        return Ok(None);
    }
    if !own.dry_run && left_unchanged(&parts, &own.leave) {
        return Err(rejected(&parts, &refused, &unused));
    }
    let (mut files, mut changed) = (Vec::new(), Vec::new());
    for (k, part) in parts.iter().enumerate() {
        if k > 0 && !part.own.contains(&true) {
            continue;
        }
        let text = if own.dry_run {
            texts[k].clone()
        } else {
            let new = part.corrections.iter().zip(part.own);
            let new: Vec<_> = new.map(|(new, own)| new.replacement.clone().filter(|_| *own)).collect();
            part.program.rewritten(&new).map_err(|error| about(part.file, error))?
        };
        changed.extend(changed_lines(&short(part.file), &texts[k], &text));
        files.push(RewrittenFile { file: part.file.into(), text, rows: rows(part) });
    }
    let mut stated = statements::statements(fitted, &parts, &options);
    let mut view = view(fitted, &parts, own.dry_run, taught::open(&parts, &options));
    // With offsets no program is written.
    view.changed = if own.offsets { Vec::new() } else { changed };
    view.notes.extend(stated.iter().cloned());
    stated.extend(kept(&paths[parts.len()..], &programs[parts.len()..]));
    stated.extend(notes(&parts, &own.leave));
    let gathered = match own.offsets {
        true => {
            gathered(&programs[..parts.len()], &corrections, &options).map_err(|error| about(file, error))?
        }
        false => Gathered::default(),
    };
    let labels = parts.iter().map(Labels::of).collect();
    Ok(Some(Rewritten {
        files,
        view,
        refused,
        notes: stated,
        warnings,
        unused,
        gathered,
        labels,
        offsets: Vec::new(),
    }))
}

/// Whether nothing is compensated, and something is refused: the program would be the one that was read.
fn left_unchanged(parts: &[Part<'_>], leave: &[String]) -> bool {
    let all = parts.iter().flat_map(|part| part.program.points().iter().zip(part.corrections).zip(part.own));
    let own = all.filter(|((point, _), own)| **own && !left(leave, &point.name));
    let outcomes: Vec<Outcome> = own.map(|((_, correction), _)| correction.outcome).collect();
    let open = |outcome: &Outcome| matches!(outcome, Outcome::Refused | Outcome::Singular);
    outcomes.contains(&Outcome::Refused) && outcomes.iter().all(open)
}

fn left(names: &[String], name: &str) -> bool {
    names.iter().any(|left| left.eq_ignore_ascii_case(name))
}

/// Leaves the points of these names as they are; names that are not there, and in words.
fn leave(
    names: &[String],
    programs: &[Program],
    corrections: &mut [Vec<Correction>],
) -> Vec<(String, String)> {
    let points = || programs.iter().flat_map(Program::points).map(|point| &point.name);
    let missing = || programs.iter().flat_map(Program::notes).filter_map(|note| note.missing.as_ref());
    let unknown =
        names.iter().filter(|name| !points().chain(missing()).any(|other| other.eq_ignore_ascii_case(name)));
    let unknown = unknown
        .map(|name| (name.clone(), format!("--leave: no point of the program is called `{name}`")))
        .collect();
    for (program, corrections) in programs.iter().zip(corrections) {
        for (point, correction) in program.points().iter().zip(corrections) {
            if left(names, &point.name) {
                correction.outcome = Outcome::Refused;
                correction.reason = "it stays as it is (--leave)".into();
                correction.replacement = None;
            }
        }
    }
    unknown
}

/// A line for each point and statement that stands against the program.
fn refusals(parts: &[Part<'_>], leave: &[String]) -> Vec<(PathBuf, usize, String)> {
    let mut all = Vec::new();
    for part in parts {
        let points = part.program.points().iter().zip(part.corrections).zip(part.own);
        let refused = points
            .filter(|((point, correction), own)| {
                **own && correction.outcome == Outcome::Refused && !left(leave, &point.name)
            })
            .map(|((point, correction), _)| (point.line, format!("{}: {}", point.name, correction.reason)));
        let notes = part.program.notes().iter().filter(|note| note.file == 0).filter_map(|note| {
            let words = match &note.missing {
                Some(point) if left(leave, point) => return None,
                Some(point) => format!(
                    "{}: {}; add the file that has it (--with FILE), or state that it stays as it is (--leave {point})",
                    note.name, note.words
                ),
                None if note.refuses => format!("{}: {}", note.name, note.words),
                None => return None,
            };
            Some((note.line, words))
        });
        let mut lines: Vec<(usize, String)> = refused.chain(notes).collect();
        lines.sort();
        lines.dedup();
        all.extend(lines.into_iter().map(|(line, words)| (part.file.to_path_buf(), line, words)));
    }
    all
}

/// Points of tables to which the program goes: they are those of other programs, too.
fn kept(paths: &[&Path], programs: &[Program]) -> Vec<String> {
    let one = |(path, program): (&&Path, &Program)| {
        let reached = program.points().iter().zip(program.reached()).filter(|(_, reached)| *reached);
        let names: Vec<&str> = reached.map(|(point, _)| point.name.as_str()).collect();
        (!names.is_empty()).then(|| {
            format!(
                "motions go to points of {}, which stay as they are, as other programs may use them: {}",
                short(path),
                names.join(", ")
            )
        })
    };
    paths.iter().zip(programs).filter_map(one).collect()
}

fn notes(parts: &[Part<'_>], leave: &[String]) -> Vec<String> {
    let mut all = Vec::new();
    for part in parts {
        let file = part.file.display();
        for note in part.program.notes().iter().filter(|note| note.file == 0 && !note.refuses) {
            if note.missing.as_ref().is_none_or(|point| left(leave, point)) {
                all.push(format!("{file}:{}: {}: {}: it stays as it is", note.line, note.name, note.words));
            }
        }
        let points = part.program.points().iter().zip(part.own);
        let unused: Vec<&str> =
            points.filter(|(_, own)| !**own).map(|(point, _)| point.name.as_str()).collect();
        if !unused.is_empty() {
            let mut names = unused[..unused.len().min(5)].join(", ");
            if unused.len() > 5 {
                names.push_str(", …");
            }
            let (stay, they) = if unused.len() == 1 { ("stays", "it") } else { ("stay", "them") };
            all.push(format!(
                "{file}: {} {stay} unchanged, as no motion in the files given goes to {they}: {names}",
                count(unused.len(), "point")
            ));
        }
    }
    all.truncate(LISTED);
    all
}

fn rejected(
    parts: &[Part<'_>],
    refused: &[(PathBuf, usize, String)],
    unused: &[(String, String)],
) -> WorkflowError {
    let mut lines: Vec<String> = refused
        .iter()
        .take(LISTED)
        .map(|(file, line, words)| format!("{}:{line}: {words}", file.display()))
        .collect();
    if refused.len() > LISTED {
        lines.push(format!("and {} more", refused.len() - LISTED));
    }
    lines.extend(unused.iter().map(|(_, words)| words.clone()));
    let points: usize = parts.iter().map(|part| part.own.iter().filter(|own| **own).count()).sum();
    let statements = parts
        .iter()
        .flat_map(|part| part.program.notes().iter().filter(|note| note.file == 0))
        .filter(|note| note.refuses || note.missing.is_some());
    let (refused, all) = (refused.len(), points + statements.count());
    let remedy = match refused < all && !left_unchanged(parts, &[]) {
        true => "--mark leaves them as they are; --dry-run writes the table alone",
        false => "--dry-run writes the table alone",
    };
    lines.push(format!(
        "nothing is written: {refused} of {} cannot be compensated. {remedy}",
        count(all, "point")
    ));
    WorkflowError::Input(lines.join("\n"))
}
