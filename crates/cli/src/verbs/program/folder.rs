//! `compensate --program BACKUP/ --out NEW/`: every program of a controller's backup, with its frames, tools and loads.

use super::asked::{Asked, Files};
use super::backup::{Backup, backup};
use super::rewriting::{Rewritten, RewrittenFile, rewritten};
use super::{LISTED, fitted, offsets, table_of, tally};
use crate::args::Compensate;
use crate::failure::Failure;
use crate::terminal;
use crate::verbs::print_json;
use crate::verbs::reporting::Folder;
use std::path::{Path, PathBuf};
use truepose_errormodel::FittedModel;
use truepose_io::{WholeFiles, check_writable, corrections_file, make_folder};
use truepose_report::{ProgramView, count, program_report};

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
    let asked = Asked { own, frame: &args.frame, tcp: &args.tcp, frames: args.frames.as_deref() };
    let (made, backup) = compensated(&fitted, from, &asked)?;
    let short = |path: &Path| path.strip_prefix(from).unwrap_or(path).to_path_buf();
    if own.offsets {
        let all = joined(from, made, &short)?;
        let inputs: Vec<&Path> =
            backup.programs.iter().flatten().chain(&backup.tables).map(PathBuf::as_path).collect();
        offsets::write(args, &all, page.as_ref(), &[&[&*args.fit], &inputs[..]].concat())?;
        if !args.json {
            refusals(&backup, &short).iter().for_each(|line| terminal::print(&format!("{line}\n")));
        }
        return complete(&backup, "in no offset");
    }
    let view = merged(from, &made, &short);
    let mut files = WholeFiles::default();
    let mut inputs: Vec<&Path> = vec![&args.fit];
    for part in made.iter().flat_map(|program| &program.files) {
        let out = args.out.join(short(&part.file));
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
    for line in notes(&made, &short) {
        terminal::log(&format!("note: {line}"));
    }
    if let Some(page) = &page {
        terminal::log(&format!("wrote {}", page.page().display()));
    }
    match args.json {
        true => print_json(&view)?,
        false => summary(args, &made, &backup, &short),
    }
    complete(&backup, "not written")
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

/// The programs of a folder, and its files.
fn compensated(
    fitted: &FittedModel,
    from: &Path,
    asked: &Asked<'_>,
) -> Result<(Vec<Rewritten>, Backup), Failure> {
    let mut backup = backup(from, asked.own.language)?;
    backup.tables.extend(asked.own.with.iter().map(|file| file.to_path_buf()));
    let mut made: Vec<Rewritten> = Vec::new();
    for files in &backup.programs {
        let tables = backup.tables.iter().filter(|table| !files.contains(table)).map(PathBuf::as_path);
        let tables: Vec<&Path> = tables.chain(backup.called_by(files)).collect();
        let of = Files { own: files.iter().map(PathBuf::as_path).collect(), tables };
        match rewritten(fitted, &of, asked) {
            Ok(Some(program)) => made.push(program),
            Ok(None) => backup.still.extend_from_slice(files),
            Err(failure) => backup.refused.push((files[0].clone(), failure.message())),
        }
    }
    if made.is_empty() {
        let refused = refusals(&backup, &|path| path.strip_prefix(from).unwrap_or(path).to_path_buf());
        let none = format!("{}: no program is compensated, and nothing is written", from.display());
        return Err(Failure::Input([&refused[..], &[none]].concat().join("\n")));
    }
    Ok((made, backup))
}

/// All programs of a folder as one; `refused` has a line 0 for each program that is not compensated.
pub(crate) fn whole(fitted: &FittedModel, from: &Path, asked: &Asked<'_>) -> Result<Rewritten, Failure> {
    let (made, backup) = compensated(fitted, from, asked)?;
    let short = |path: &Path| path.strip_prefix(from).unwrap_or(path).to_path_buf();
    let mut all = joined(from, made, &short)?;
    all.refused = backup.refused.into_iter().map(|(file, words)| (file, 0, words)).collect();
    Ok(all)
}

/// Programs as one, with the offsets of all of them where they are wanted.
fn joined(from: &Path, made: Vec<Rewritten>, short: &dyn Fn(&Path) -> PathBuf) -> Result<Rewritten, Failure> {
    let mut all =
        Rewritten { view: merged(from, &made, short), notes: notes(&made, short), ..Rewritten::default() };
    let asked = made.iter().any(|program| !program.gathered.is_empty());
    for program in made {
        let name = program.files.first().map(|part| short(&part.file).display().to_string());
        all.gathered.join(program.gathered, all.labels.len(), &name.unwrap_or_default());
        all.labels.extend(program.labels);
        all.files.extend(program.files);
    }
    if asked {
        offsets::fill(&mut all, &|file| short(file).display().to_string())?;
    }
    Ok(all)
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

/// All programs on one page.
fn merged(from: &Path, made: &[Rewritten], short: &dyn Fn(&Path) -> PathBuf) -> ProgramView {
    let mut all = ProgramView { program: from.display().to_string(), ..ProgramView::default() };
    for program in made {
        let mut view = program.view.clone();
        for point in &mut view.points {
            let named =
                |part: &&RewrittenFile| part.file.file_name().is_some_and(|name| *name == *point.file);
            if let Some(part) = program.files.iter().find(named) {
                point.file = short(&part.file).display().to_string();
            }
        }
        let frames = view.open_frames.into_iter().filter(|name| !all.open_frames.contains(name));
        all.open_frames.extend(frames.collect::<Vec<_>>());
        let name =
            program.files.first().map(|part| short(&part.file).display().to_string()).unwrap_or_default();
        all.notes.extend(view.notes.into_iter().map(|note| format!("{name}: {note}")));
        all.points.append(&mut view.points);
        all = ProgramView {
            robot: view.robot,
            language: view.language,
            dry_run: view.dry_run,
            joints: view.joints,
            ..all
        };
    }
    all
}

/// Each note once; names of options that no program has.
fn notes(made: &[Rewritten], short: &dyn Fn(&Path) -> PathBuf) -> Vec<String> {
    let mut all: Vec<(String, Vec<String>)> = Vec::new();
    for program in made {
        let name =
            program.files.first().map(|part| short(&part.file).display().to_string()).unwrap_or_default();
        for note in &program.notes {
            match all.iter_mut().find(|(other, _)| other == note) {
                Some((_, names)) => names.push(name.clone()),
                None => all.push((note.clone(), vec![name.clone()])),
            }
        }
    }
    let mut lines: Vec<String> = all
        .into_iter()
        .map(|(note, names)| match &names[..] {
            [name] => format!("{name}: {note}"),
            _ => format!("{} and {}: {note}", names[0], count(names.len() - 1, "other program")),
        })
        .collect();
    for (name, words) in made.first().map_or(&[][..], |first| &first.unused) {
        if made.iter().all(|program| program.unused.iter().any(|(other, _)| other == name)) {
            lines.push(words.clone());
        }
    }
    lines
}

/// A line for each program that is refused, with those of its points.
fn refusals(backup: &Backup, short: &dyn Fn(&Path) -> PathBuf) -> Vec<String> {
    let one = |(file, words): &(PathBuf, String)| {
        let mut lines = vec![format!("refused: {}", short(file).display())];
        let own = words.lines().filter(|line| !line.starts_with("nothing is written"));
        lines.extend(own.map(|line| format!("  {line}")));
        lines
    };
    backup.refused.iter().flat_map(one).collect()
}

fn summary(args: &Compensate, made: &[Rewritten], backup: &Backup, short: &dyn Fn(&Path) -> PathBuf) {
    let what = if args.robot_program.dry_run { "as it is" } else { "compensated" };
    for program in made {
        let names: Vec<String> =
            program.files.iter().map(|part| short(&part.file).display().to_string()).collect();
        let outcomes = program.view.points.iter().map(|point| point.outcome.as_str());
        terminal::print(&format!(
            "{what}: {}: {}: {}\n",
            names.join(", "),
            count(program.view.points.len(), "point"),
            tally(outcomes)
        ));
    }
    for line in refusals(backup, short) {
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
                files.iter().take(LISTED).map(|file| short(file).display().to_string()).collect();
            if files.len() > LISTED {
                names.push(format!("and {} more", files.len() - LISTED));
            }
            terminal::print(&format!("not written: {word}: {}\n", names.join(", ")));
        }
    }
    terminal::print(&format!(
        "{} of {} written to {}\n",
        made.len(),
        count(made.len() + backup.refused.len(), "program"),
        args.out.display()
    ));
}
