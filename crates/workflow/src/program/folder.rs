//! Every program of a controller's backup, with its frames, tools and loads.

use super::backup::{Backup, backup};
use super::offsets;
use super::request::{Files, ProgramRequest};
use super::rewriting::{Rewritten, RewrittenFile, rewritten};
use crate::error::WorkflowError;
use std::path::{Path, PathBuf};
use truepose_errormodel::FittedModel;
use truepose_report::{ProgramView, count};

/// The programs of a folder with compensated points.
#[derive(Debug)]
pub struct FolderRewritten {
    /// One for each program.
    pub programs: Vec<Rewritten>,
    /// The files of the folder.
    pub backup: Backup,
    from: PathBuf,
}

/// Rewrites all programs of a folder. `fitted` is that of the robot alone ([`FittedModel::of_robot`]), in one session.
///
/// # Errors
/// When files cannot be read, or no program can be compensated.
pub fn rewrite_folder(
    fitted: &FittedModel,
    from: &Path,
    request: &ProgramRequest,
) -> Result<FolderRewritten, WorkflowError> {
    let mut backup = backup(from, request.language)?;
    backup.tables.extend(request.with.iter().cloned());
    let mut programs: Vec<Rewritten> = Vec::new();
    for files in &backup.programs {
        let tables = backup.tables.iter().filter(|table| !files.contains(table)).map(PathBuf::as_path);
        let tables: Vec<&Path> = tables.chain(backup.called_by(files)).collect();
        let of = Files { own: files.iter().map(PathBuf::as_path).collect(), tables };
        match rewritten(fitted, &of, request) {
            Ok(Some(program)) => programs.push(program),
            Ok(None) => backup.still.extend_from_slice(files),
            Err(error) => backup.refused.push((files[0].clone(), error.to_string())),
        }
    }
    let made = FolderRewritten { programs, backup, from: from.into() };
    if made.programs.is_empty() {
        let none = format!("{}: no program is compensated, and nothing is written", from.display());
        return Err(WorkflowError::Input([&made.refusals()[..], &[none]].concat().join("\n")));
    }
    Ok(made)
}

impl FolderRewritten {
    /// A file of the folder, from there.
    pub fn short(&self, path: &Path) -> PathBuf {
        path.strip_prefix(&self.from).unwrap_or(path).to_path_buf()
    }

    /// The name of a program: its first file.
    fn name(&self, program: &Rewritten) -> String {
        program.files.first().map(|part| self.short(&part.file).display().to_string()).unwrap_or_default()
    }

    /// All programs as one, with the offsets of all of them where they are requested; and the files of the folder. `refused` has line 0 for each
    /// program that is not compensated.
    ///
    /// # Errors
    /// When offsets are requested, and none improves the points.
    pub fn joined(self) -> Result<(Rewritten, Backup), WorkflowError> {
        let (view, notes) = (self.view(), self.notes());
        let names: Vec<String> = self.programs.iter().map(|program| self.name(program)).collect();
        let mut all = Rewritten { view, notes, ..Rewritten::default() };
        let requested = self.programs.iter().any(|program| !program.gathered.is_empty());
        let FolderRewritten { programs, backup, from } = self;
        for (program, name) in programs.into_iter().zip(names) {
            all.gathered.join(program.gathered, all.labels.len(), &name);
            all.labels.extend(program.labels);
            all.files.extend(program.files);
            let more = program.warnings.into_iter().filter(|words| !all.warnings.contains(words));
            all.warnings.extend(more.collect::<Vec<_>>());
        }
        if requested {
            let short = |file: &Path| file.strip_prefix(&from).unwrap_or(file).display().to_string();
            offsets::fill(&mut all, &short)?;
        }
        all.refused = backup.refused.iter().map(|(file, words)| (file.clone(), 0, words.clone())).collect();
        Ok((all, backup))
    }

    /// All programs on one page.
    pub fn view(&self) -> ProgramView {
        let mut all = ProgramView { program: self.from.display().to_string(), ..ProgramView::default() };
        for program in &self.programs {
            let mut view = program.view.clone();
            let own = view.points.iter_mut().map(|point| &mut point.file);
            for file in own.chain(view.changed.iter_mut().map(|line| &mut line.file)) {
                let named = |part: &&RewrittenFile| part.file.file_name().is_some_and(|name| *name == **file);
                if let Some(part) = program.files.iter().find(named) {
                    *file = self.short(&part.file).display().to_string();
                }
            }
            let frames = view.open_frames.into_iter().filter(|name| !all.open_frames.contains(name));
            all.open_frames.extend(frames.collect::<Vec<_>>());
            let name = self.name(program);
            all.notes.extend(view.notes.into_iter().map(|note| format!("{name}: {note}")));
            all.points.append(&mut view.points);
            all.changed.append(&mut view.changed);
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
    pub fn notes(&self) -> Vec<String> {
        let mut all: Vec<(String, Vec<String>)> = Vec::new();
        for program in &self.programs {
            let name = self.name(program);
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
        for (name, words) in self.programs.first().map_or(&[][..], |first| &first.unused) {
            if self.programs.iter().all(|program| program.unused.iter().any(|(other, _)| other == name)) {
                lines.push(words.clone());
            }
        }
        lines
    }

    /// A line for each program that is refused, with those of its points.
    pub fn refusals(&self) -> Vec<String> {
        let one = |(file, words): &(PathBuf, String)| {
            let mut lines = vec![format!("refused: {}", self.short(file).display())];
            let own = words.lines().filter(|line| !line.starts_with("nothing is written"));
            lines.extend(own.map(|line| format!("  {line}")));
            lines
        };
        self.backup.refused.iter().flat_map(one).collect()
    }
}
