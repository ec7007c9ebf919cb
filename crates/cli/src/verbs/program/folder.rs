//! `compensate --program BACKUP/ --out NEW/`: every program of a controller's backup, with its frames, tools and loads.

use super::asked::{Asked, Files};
use super::rewriting::{Rewritten, RewrittenFile, rewritten};
use super::{LISTED, fitted, table_of, tally};
use crate::args::Compensate;
use crate::failure::Failure;
use crate::terminal;
use crate::verbs::print_json;
use crate::verbs::reporting::Folder;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use truepose_controllers::{Dialect, Program, Role, linked};
use truepose_errormodel::FittedModel;
use truepose_io::{WholeFiles, corrections_file, make_folder, read_bytes};
use truepose_report::{ProgramView, count, program_report};

/// Folders in folders, at most.
const DEEPEST: usize = 16;

/// The files of a backup.
#[derive(Debug, Default)]
struct Backup {
    /// Those of each program, which are compensated together.
    programs: Vec<Vec<PathBuf>>,
    tables: Vec<PathBuf>,
    /// Programs that are not read, and why.
    refused: Vec<(PathBuf, String)>,
    /// Programs without a motion and without a point.
    still: Vec<PathBuf>,
    /// No programs.
    others: Vec<PathBuf>,
}

/// Runs it.
pub(super) fn run(args: &Compensate, from: &Path) -> Result<(), Failure> {
    if args.robot_program.offsets {
        return Err(Failure::Input("--offsets: one program is needed, not a folder".into()));
    }
    apart(from, &args.out)?;
    let page = Folder::with_head(args.report.as_ref(), "compensation.json", args.certificate.as_ref())?;
    let fitted = fitted(args)?;
    let own = &args.robot_program;
    let asked = Asked { own, frame: &args.frame, tcp: &args.tcp, frames: args.frames.as_deref() };
    let (made, backup) = compensated(&fitted, from, &asked)?;
    let short = |path: &Path| path.strip_prefix(from).unwrap_or(path).to_path_buf();
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
    match backup.refused.len() {
        0 => Ok(()),
        refused => {
            let programs = count(refused, "program");
            Err(Failure::Criterion(format!(
                "{programs} cannot be compensated and {} not written",
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
        let tables: Vec<&Path> =
            backup.tables.iter().filter(|table| !files.contains(table)).map(PathBuf::as_path).collect();
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
    Ok(Rewritten {
        view: merged(from, &made, &short),
        notes: notes(&made, &short),
        files: made.into_iter().flat_map(|program| program.files).collect(),
        refused: backup.refused.into_iter().map(|(file, words)| (file, 0, words)).collect(),
        unused: Vec::new(),
        offsets: Vec::new(),
    })
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

/// All files of a folder and of those in it, in order of their names.
fn walk(folder: &Path, depth: usize, all: &mut Vec<PathBuf>) -> Result<(), Failure> {
    let unread = |error: std::io::Error| Failure::Input(format!("{}: {error}", folder.display()));
    let mut entries: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unread)? {
        entries.push(entry.map_err(unread)?.path());
    }
    entries.sort();
    for path in entries {
        // A link to a folder may lead back.
        if path.symlink_metadata().is_ok_and(|found| found.is_dir()) {
            if depth == DEEPEST {
                return Err(Failure::Input(format!("{}: its folders are too deep", path.display())));
            }
            walk(&path, depth + 1, all)?;
        } else if path.is_file() {
            all.push(path);
        }
    }
    Ok(())
}

fn backup(folder: &Path, language: Option<Dialect>) -> Result<Backup, Failure> {
    let mut all = Vec::new();
    walk(folder, 0, &mut all)?;
    let mut found: Vec<Dialect> = Vec::new();
    for dialect in all.iter().filter_map(|file| Dialect::of_file(file).ok()) {
        if !found.contains(&dialect) {
            found.push(dialect);
        }
    }
    let dialect = match (language, &found[..]) {
        (Some(dialect), _) => dialect,
        (None, [dialect]) => *dialect,
        (None, []) => {
            return Err(Failure::Input(format!("{}: there is no robot program in it", folder.display())));
        }
        (None, several) => {
            let words: Vec<&str> = several.iter().map(|dialect| dialect.word()).collect();
            return Err(Failure::Input(format!(
                "{}: it has programs of several languages ({}); name one with --language",
                folder.display(),
                words.join(", ")
            )));
        }
    };
    let mut backup = Backup::default();
    let mut programs = Vec::new();
    for file in all {
        let text = read_bytes(&file)?;
        match dialect.role(&file, &text) {
            Role::Program => programs.push((file, text)),
            Role::Table => backup.tables.push(file),
            Role::Other => backup.others.push(file),
        }
    }
    match dialect {
        Dialect::Krl => pairs(programs, &mut backup),
        Dialect::Rapid => tasks(programs, &mut backup),
        _ => backup.programs = programs.into_iter().map(|(file, _)| vec![file]).collect(),
    }
    Ok(backup)
}

/// KRL: `.src` and `.dat` of one name in one folder.
fn pairs(programs: Vec<(PathBuf, Vec<u8>)>, backup: &mut Backup) {
    let mut pairs: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for (file, _) in programs {
        pairs.entry(file.with_extension("").to_string_lossy().to_lowercase()).or_default().push(file);
    }
    for mut pair in pairs.into_values() {
        pair.sort_by_key(|file| file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("dat")));
        backup.programs.push(pair);
    }
}

/// RAPID: the modules of a task use the points of each other; those that do are one program.
fn tasks(programs: Vec<(PathBuf, Vec<u8>)>, backup: &mut Backup) {
    let mut tasks: BTreeMap<PathBuf, Vec<(PathBuf, Vec<u8>)>> = BTreeMap::new();
    for (file, text) in programs {
        let is_task = |folder: &&Path| {
            folder.file_name().is_some_and(|name| name.to_string_lossy().to_lowercase().starts_with("task"))
        };
        let task = file.ancestors().find(is_task).or(file.parent()).map(Path::to_path_buf);
        // One that is not read is none of the others' files.
        match Program::read(&text, &[], Dialect::Rapid) {
            Ok(_) => tasks.entry(task.unwrap_or_default()).or_default().push((file, text)),
            Err(error) => backup.refused.push((file.clone(), format!("{}:{error}", file.display()))),
        }
    }
    for modules in tasks.into_values() {
        let texts: Vec<&[u8]> = modules.iter().map(|(_, text)| text.as_slice()).collect();
        let Ok(read) = Program::read_all(&texts, Dialect::Rapid) else { continue };
        let groups = linked(&read);
        let files = |group: &Vec<usize>| group.iter().map(|&k| modules[k].0.clone()).collect();
        backup.programs.extend(groups.iter().map(files));
        for (k, (file, text)) in modules.iter().enumerate() {
            let text = String::from_utf8_lossy(text).to_lowercase();
            if ["tooldata", "wobjdata", "loaddata"].iter().any(|word| text.contains(word)) {
                backup.tables.push(file.clone());
            } else if !groups.iter().flatten().any(|&other| other == k) {
                backup.still.push(file.clone());
            }
        }
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
