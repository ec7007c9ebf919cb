//! `compensate --program BACKUP/ --out NEW/`: every program of a controller's backup, with its frames, tools and loads.

use super::{fitted, offsets, table_of, tally};
use crate::args::Compensate;
use crate::failure::Failure;
use crate::terminal;
use crate::verbs::print_json;
use crate::verbs::reporting::Folder;
use std::path::{Path, PathBuf};
use truepose_io::{WholeFiles, check_writable, corrections_file, make_folder};
use truepose_report::{count, program_report};
use truepose_workflow::program::{Backup, FolderRewritten, LISTED, rewrite_folder};

/// Runs it.
pub(super) fn run(args: &Compensate, from: &Path) -> Result<(), Failure> {
    if args.robot_program.offsets {
        check_writable(&args.out)?;
    } else {
        apart(from, &args.out)?;
    }
    let page = Folder::with_head(args.report.as_ref(), "compensation.json", args.certificate.as_ref())?;
    let fitted = fitted(args)?;
    let own = &args.robot_program;
    let made = rewrite_folder(&fitted, from, &own.request([&args.frame, &args.tcp], args.frames.as_ref()))?;
    let refusals = made.refusals();
    if own.offsets {
        let (all, backup) = made.joined()?;
        terminal::warn(&all.warnings);
        let inputs: Vec<&Path> =
            backup.programs.iter().flatten().chain(&backup.tables).map(PathBuf::as_path).collect();
        offsets::write(args, &all, page.as_ref(), &[&[&*args.fit], &inputs[..]].concat())?;
        if !args.json {
            refusals.iter().for_each(|line| terminal::print(&format!("{line}\n")));
        }
        return complete(&backup, "in no offset");
    }
    let mut warnings: Vec<&String> = made.programs.iter().flat_map(|program| &program.warnings).collect();
    warnings.dedup();
    terminal::warn(&warnings);
    let (view, backup) = (made.view(), &made.backup);
    let mut files = WholeFiles::default();
    let mut inputs: Vec<&Path> = vec![&args.fit];
    for part in made.programs.iter().flat_map(|program| &program.files) {
        let out = args.out.join(made.short(&part.file));
        make_folder(out.parent().unwrap_or(&args.out))?;
        files.add(&out, &part.text)?;
        files.push(corrections_file(table_of(&out), fitted.chain(), &part.rows)?)?;
        inputs.push(&part.file);
    }
    if let Some(page) = &page {
        inputs.extend(backup.tables.iter().map(PathBuf::as_path));
        page.add(&mut files, &view, &inputs, |run| Ok(program_report(&view, run)))?;
    }
    files.finish()?;
    for line in made.notes() {
        terminal::log(&format!("note: {line}"));
    }
    if let Some(page) = &page {
        terminal::log(&format!("wrote {}", page.page().display()));
    }
    match args.json {
        true => print_json(&view)?,
        false => summary(args, &made, &refusals),
    }
    complete(backup, "not written")
}

/// Whether all programs are compensated.
fn complete(backup: &Backup, what: &str) -> Result<(), Failure> {
    match backup.refused.len() {
        0 => Ok(()),
        refused => {
            let programs = count(refused, "program");
            Err(Failure::Criterion(format!(
                "{programs} cannot be compensated and {} {what}",
                if refused == 1 { "is" } else { "are" }
            )))
        }
    }
}

/// The new folder has to be another one, outside of the backup.
fn apart(from: &Path, out: &Path) -> Result<(), Failure> {
    let refused = |words: &str| Err(Failure::Input(format!("--out: `{}` {words}", out.display())));
    if out.exists() && !out.is_dir() {
        return refused("is a file; a folder is written for a folder");
    }
    let whole = |path: &Path| {
        let known = path.ancestors().find_map(|above| Some((above, above.canonicalize().ok()?)));
        known.map_or(path.to_path_buf(), |(above, real)| {
            real.join(path.strip_prefix(above).unwrap_or(Path::new("")))
        })
    };
    let here = std::env::current_dir().unwrap_or_default();
    let (from, to) = (whole(&here.join(from)), whole(&here.join(out)));
    match to.starts_with(&from) || from.starts_with(&to) {
        true => refused("is in the folder of --program, or that folder is in it; name another one"),
        false => Ok(()),
    }
}

fn summary(args: &Compensate, made: &FolderRewritten, refusals: &[String]) {
    let FolderRewritten { programs, backup, .. } = made;
    let what = if args.robot_program.dry_run { "as it is" } else { "compensated" };
    for program in programs {
        let names: Vec<String> =
            program.files.iter().map(|part| made.short(&part.file).display().to_string()).collect();
        let outcomes = program.view.points.iter().map(|point| point.outcome.as_str());
        terminal::print(&format!(
            "{what}: {}: {}: {}\n",
            names.join(", "),
            count(program.view.points.len(), "point"),
            tally(outcomes)
        ));
    }
    for line in refusals {
        terminal::print(&format!("{line}\n"));
    }
    // A module may have tools and motions.
    let program = |file: &&PathBuf| backup.programs.iter().flatten().any(|own| own == *file);
    let tables: Vec<PathBuf> = backup.tables.iter().filter(|file| !program(file)).cloned().collect();
    for (word, files) in
        [("no points", &backup.still), ("frames, tools, loads", &tables), ("no programs", &backup.others)]
    {
        if !files.is_empty() {
            let mut names: Vec<String> =
                files.iter().take(LISTED).map(|file| made.short(file).display().to_string()).collect();
            if files.len() > LISTED {
                names.push(format!("and {} more", files.len() - LISTED));
            }
            terminal::print(&format!("not written: {word}: {}\n", names.join(", ")));
        }
    }
    terminal::print(&format!(
        "{} of {} written to {}\n",
        programs.len(),
        count(programs.len() + backup.refused.len(), "program"),
        args.out.display()
    ));
}
