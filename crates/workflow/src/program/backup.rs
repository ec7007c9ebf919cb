//! The files of a controller's backup: programs, their tables, and others.

use crate::error::WorkflowError;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use truepose_controllers::{Dialect, Program, Role, calls, linked};
use truepose_io::read_bytes;

/// Folders in folders, at most.
const DEEPEST: usize = 16;

/// The files of a backup.
#[derive(Debug, Default)]
pub struct Backup {
    /// Those of each program, which are compensated together.
    pub programs: Vec<Vec<PathBuf>>,
    /// Those with frames, tools and loads.
    pub tables: Vec<PathBuf>,
    /// Programs that are not read, and why.
    pub refused: Vec<(PathBuf, String)>,
    /// Programs without a motion and without a point.
    pub still: Vec<PathBuf>,
    /// No programs.
    pub others: Vec<PathBuf>,
    /// Of each program.
    texts: BTreeMap<PathBuf, (Dialect, Vec<u8>)>,
}

impl Backup {
    /// Further programs that these call, and that those call: they may set frames, tools and loads.
    pub(super) fn called_by(&self, files: &[PathBuf]) -> Vec<&Path> {
        let mut all: Vec<&Path> = Vec::new();
        let mut open: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
        while let Some(file) = open.pop() {
            let Some((dialect, text)) = self.texts.get(file) else { continue };
            for (other, (_, other_text)) in &self.texts {
                let name = other.file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
                // One that is not read is no reason against those that call it.
                let known = files.contains(other) || all.contains(&other.as_path());
                if !known && calls(*dialect, text, &name) && Program::read(other_text, &[], *dialect).is_ok()
                {
                    all.push(other);
                    open.push(other);
                }
            }
        }
        all
    }
}

/// All files of a folder and of those in it, in order of their names.
fn walk(folder: &Path, depth: usize, all: &mut Vec<PathBuf>) -> Result<(), WorkflowError> {
    let unread = |error: std::io::Error| WorkflowError::Input(format!("{}: {error}", folder.display()));
    let mut entries: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unread)? {
        entries.push(entry.map_err(unread)?.path());
    }
    entries.sort();
    for path in entries {
        // A link to a folder may lead back.
        if path.symlink_metadata().is_ok_and(|found| found.is_dir()) {
            if depth == DEEPEST {
                return Err(WorkflowError::Input(format!("{}: its folders are too deep", path.display())));
            }
            walk(&path, depth + 1, all)?;
        } else if path.is_file() {
            all.push(path);
        }
    }
    Ok(())
}

/// Tells the files of a folder apart.
pub(super) fn backup(folder: &Path, language: Option<Dialect>) -> Result<Backup, WorkflowError> {
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
            return Err(WorkflowError::Input(format!(
                "{}: there is no robot program in it",
                folder.display()
            )));
        }
        (None, several) => {
            let words: Vec<&str> = several.iter().map(|dialect| dialect.word()).collect();
            return Err(WorkflowError::Input(format!(
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
            Role::Program => {
                backup.texts.insert(file.clone(), (dialect, text.clone()));
                programs.push((file, text));
            }
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
