//! What a run reads and writes: nothing that it reads is overwritten, and nothing is written twice.

use super::program::table_of;
use crate::args::{Files, NamedFile, Verb};
use crate::failure::Failure;
use std::path::{Path, PathBuf};
use truepose_io::{FileLock, Occupied, make_folder, robot_files, same_file};

/// Refuses a run that would write over its own input or output, before anything is read.
pub fn apart(verb: &Verb, files: &Files) -> Result<(), Failure> {
    once(&files.read)?;
    let read = with_beside(&files.read);
    for folder in &files.folders {
        for other in read.iter().chain(&files.written) {
            if may_be_written(&folder.option, &folder.path, &other.path) {
                let words = format!(
                    "a file in `{}` may get the name of `{}`, which {} names; name another folder",
                    folder.path.display(),
                    other.path.display(),
                    other.option
                );
                return refused(&folder.option, words);
            }
        }
    }
    let mut whole: Vec<(&str, PathBuf)> = Vec::new();
    for (NamedFile { option, path, .. }, is_folder) in files
        .folders
        .iter()
        .map(|folder| (folder, true))
        .chain(files.written.iter().map(|file| (file, false)))
    {
        if path == Path::new("-") {
            return refused(
                option,
                "`-` does not stand for standard output; name a file, or /dev/stdout".into(),
            );
        }
        kept(option, path, &read)?;
        for (other, theirs) in &whole {
            let folders = is_folder && files.folders.iter().any(|folder| folder.option == *other);
            if same_file(path, theirs) && !folders {
                let words = format!("`{}` is written by {other} as well; name another file", path.display());
                return refused(option, words);
            }
        }
        whole.push((option, path.clone()));
        if option == REPORT {
            for name in PAGE {
                kept(option, &path.join(name), &read)?;
                whole.push((option, path.join(name)));
            }
        }
    }
    if let Verb::Compensate(of) = verb
        && of.robot_program.program.is_some()
    {
        kept("--out", &table_of(&of.out), &read)?;
    }
    Ok(())
}

/// Locks everything that a run writes, until it ends: another run that writes the same is refused. A file that is read and written again is
/// waited for.
pub fn locked(files: &Files) -> Result<Vec<FileLock>, Failure> {
    let mut locks = Vec::new();
    // Records first: a run that waits has nothing that another one needs.
    let (again, once): (Vec<_>, Vec<_>) = files.written.iter().partition(|file| file.again);
    for file in again {
        locks.extend(FileLock::of(&file.path, Occupied::Wait)?);
    }
    for folder in &files.folders {
        make_folder(&folder.path)?;
    }
    for file in files.folders.iter().chain(once) {
        locks.extend(FileLock::of(&file.path, Occupied::Refuse)?);
    }
    Ok(locks)
}

/// The files that are read, and those that robot descriptions among them name.
fn with_beside(read: &[NamedFile]) -> Vec<NamedFile> {
    let beside = read
        .iter()
        .flat_map(|file| robot_files(&file.path).into_iter().skip(1).map(|path| NamedFile::new(URDF, path)));
    read.iter().cloned().chain(beside).collect()
}

/// How a URDF is named that a robot description names.
const URDF: &str = "the robot's `urdf`";

/// Refuses to read twice what can be read once.
fn once(read: &[NamedFile]) -> Result<(), Failure> {
    for (k, NamedFile { option, path, .. }) in read.iter().enumerate() {
        let special = path.metadata().is_ok_and(|found| !found.is_file() && !found.is_dir());
        if let Some(other) = read[..k].iter().find(|other| special && other.path == *path) {
            let words = format!(
                "`{}` is read by {} already, and can be read only once",
                path.display(),
                other.option
            );
            return refused(option, words);
        }
    }
    Ok(())
}

/// Refuses to write one of the files that are read.
pub fn kept(option: &str, file: &Path, read: &[NamedFile]) -> Result<(), Failure> {
    match read.iter().find(|other| same_file(file, &other.path)) {
        Some(other) => {
            let words = format!(
                "`{}` is what {} reads, and would be overwritten; name another file",
                file.display(),
                other.option
            );
            refused(option, words)
        }
        None => Ok(()),
    }
}

/// The option of a report's folder.
const REPORT: &str = "--report";

/// Whether a run may write this file into a folder, besides those of [`PAGE`]: figures of a report (`NAME.svg`) and rivals (`NUMBER-NAME.json`),
/// whose names only the result has.
fn may_be_written(option: &str, folder: &Path, file: &Path) -> bool {
    let target = file.canonicalize().unwrap_or_else(|_| file.into());
    [file, &target].into_iter().any(|file| {
        let Some(name) = file.file_name().map(|name| name.to_string_lossy().to_lowercase()) else {
            return false;
        };
        let above = file.parent().filter(|above| !above.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let named = match option {
            REPORT => name.ends_with(".svg"),
            "--rivals" => {
                let number = name.split('-').next().unwrap_or("");
                let numbered = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
                numbered && number.len() < name.len() && name.ends_with(".json")
            }
            _ => true,
        };
        named && same_file(above, folder)
    })
}

/// Files of a report, whichever verb writes it.
const PAGE: [&str; 11] = [
    "index.html",
    "summary.html",
    "run.json",
    "identification.json",
    "discovery.json",
    "comparison.json",
    "compensation.json",
    "map.json",
    "plan.json",
    "prediction.json",
    "acceptance.json",
];

fn refused(option: &str, words: String) -> Result<(), Failure> {
    Err(Failure::Input(format!("{option}: {words}")))
}
