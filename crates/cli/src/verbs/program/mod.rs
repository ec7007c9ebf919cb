//! `truepose compensate --program`: a robot program with compensated points.

mod folder;
mod offsets;
mod outputs;

use super::reporting::Folder;
use super::{print_json, usable_fit};
use crate::args::{Compensate, NamedFile};
use crate::failure::Failure;
use crate::terminal;
use outputs::outputs;
use std::path::{Path, PathBuf};
use truepose_controllers::Outcome;
use truepose_errormodel::FittedModel;
use truepose_io::{WholeFiles, check_writable, corrections_file};
use truepose_report::{count, millimetres, program_report};
use truepose_workflow::in_session;
use truepose_workflow::program::{LISTED, Rewritten, rewrite_program};

/// The file of corrections beside a program.
pub fn table_of(out: &Path) -> PathBuf {
    let mut name = out.as_os_str().to_owned();
    name.push(".corrections.csv");
    name.into()
}

/// Runs it, of one program or of all in a folder; `read` are the files that it reads, with their options.
pub fn run(args: &Compensate, file: &Path, read: &[NamedFile]) -> Result<(), Failure> {
    if file.is_dir() {
        return folder::run(args, file);
    }
    check_writable(&args.out)?;
    check_writable(table_of(&args.out))?;
    let folder = Folder::with_head(args.report.as_ref(), "compensation.json", args.certificate.as_ref())?;
    let fitted = fitted(args)?;
    let own = &args.robot_program;
    let made = rewrite_program(&fitted, file, &own.request([&args.frame, &args.tcp], args.frames.as_ref()))?;
    terminal::warn(&made.warnings);
    let inputs = [Some(&args.fit), own.program.as_ref(), args.frames.as_ref(), args.certificate.as_ref()];
    let inputs: Vec<&Path> = inputs
        .into_iter()
        .flatten()
        .chain(&own.with)
        .chain(own.taught.iter().map(|taught| &taught.file))
        .map(|file| &**file)
        .collect();
    if own.offsets {
        return offsets::write(args, &made, folder.as_ref(), &inputs);
    }
    let outputs = outputs(&args.out, &made.files, read)?;
    let mut files = WholeFiles::default();
    for (out, part) in outputs.iter().zip(&made.files) {
        files.add(out, &part.text)?;
        files.push(corrections_file(table_of(out), fitted.chain(), &part.rows)?)?;
    }
    if let Some(folder) = &folder {
        folder.add(&mut files, &made.view, &inputs, |run| Ok(program_report(&made.view, run)))?;
    }
    for line in &made.notes {
        terminal::log(&format!("note: {line}"));
    }
    files.finish()?;
    if let Some(folder) = &folder {
        terminal::log(&format!("wrote {}", folder.page().display()));
    }
    if args.json {
        return print_json(&made.view);
    }
    said(args, &made, &outputs);
    Ok(())
}

/// The fit of the robot alone, in one session.
fn fitted(args: &Compensate) -> Result<FittedModel, Failure> {
    let fitted = usable_fit(&args.fit, &args.accept)?;
    Ok(in_session(fitted, args.session.as_deref(), false)?.of_robot())
}

/// `1 corrected, 2 refused`.
fn tally<'a>(outcomes: impl Iterator<Item = &'a str>) -> String {
    let outcomes: Vec<&str> = outcomes.collect();
    let of = |outcome: Outcome| outcomes.iter().filter(|word| **word == outcome.word()).count();
    let parts: Vec<String> =
        [Outcome::Corrected, Outcome::NotSignificant, Outcome::Singular, Outcome::Refused]
            .into_iter()
            .filter(|&outcome| of(outcome) > 0)
            .map(|outcome| format!("{} {}", of(outcome), outcome.word()))
            .collect();
    if parts.is_empty() { "none".into() } else { parts.join(", ") }
}

fn said(args: &Compensate, made: &Rewritten, outputs: &[PathBuf]) {
    let view = &made.view;
    let what = if args.robot_program.dry_run { "as it is" } else { "compensated" };
    terminal::print(&format!(
        "{}: {}; the program, {what}, is {}, the table {}\n",
        count(view.points.len(), "point"),
        tally(view.points.iter().map(|point| point.outcome.as_str())),
        args.out.display(),
        table_of(&args.out).display()
    ));
    if outputs.len() > 1 {
        for (out, part) in outputs.iter().zip(&made.files) {
            terminal::print(&format!(
                "  {} of {}: {}: {}\n",
                out.display(),
                part.file.display(),
                count(part.rows.len(), "point"),
                tally(part.rows.iter().map(|row| row.outcome.as_str()))
            ));
        }
    }
    let largest = view.points.iter().filter_map(|point| point.correction_mm).fold(0.0, f64::max);
    if largest > 0.0 {
        terminal::print(&format!("largest correction: {}\n", millimetres(1e-3 * largest)));
    }
    let program = args.robot_program.program.as_deref();
    let singular = view.points.iter().filter(|point| point.outcome == Outcome::Singular.word());
    for point in singular.take(LISTED) {
        terminal::print(&format!(
            "  unchanged: {}, line {}: {}: {}\n",
            point.file, point.line, point.name, point.reason
        ));
    }
    for (file, line, words) in made.refused.iter().take(LISTED) {
        let place = match program == Some(file.as_path()) {
            true => String::new(),
            false => format!("{}, ", file.display()),
        };
        terminal::print(&format!("  unchanged: {place}line {line}: {words}\n"));
    }
    if made.refused.len() > LISTED {
        terminal::print(&format!("  and {} more\n", made.refused.len() - LISTED));
    }
}
