//! Files that are being written, so that a program that has to end at once leaves none of them behind.

use crate::IoError;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::TempDir;

/// Files on their way; none once writing was stopped.
static OPEN: Mutex<Option<Open>> =
    Mutex::new(Some(Open { unfinished: Vec::new(), finished: Vec::new(), folders: Vec::new() }));

#[derive(Debug)]
struct Open {
    /// Temporary files and folders.
    unfinished: Vec<PathBuf>,
    /// Files that stand under their names, the last [`MOST`] of them.
    finished: Vec<PathBuf>,
    /// Folders that were made for output, the last [`MOST`] of them, each behind those above it.
    folders: Vec<PathBuf>,
}

impl Open {
    /// Removes folders in which nothing was written.
    fn remove_empty(folders: Vec<PathBuf>) {
        folders.iter().rev().for_each(|folder| drop(std::fs::remove_dir(folder)));
    }
}

/// Names of finished files that are remembered: more than a report has.
const MOST: usize = 256;

fn open() -> MutexGuard<'static, Option<Open>> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Puts files under their names, all of them before or all of them after [`stop_writing`]; the names are remembered.
pub(crate) fn finished<E>(
    names: impl Iterator<Item = PathBuf>,
    put: impl FnOnce() -> Result<(), E>,
    stopped: impl FnOnce() -> E,
) -> Result<(), E> {
    let mut open = open();
    let Some(files) = open.as_mut() else { return Err(stopped()) };
    put()?;
    files.finished.extend(names);
    let surplus = files.finished.len().saturating_sub(MOST);
    files.finished.drain(..surplus);
    Ok(())
}

/// Makes a temporary file and remembers it, both or neither.
pub(crate) fn begun<T>(
    make: impl FnOnce() -> io::Result<T>,
    path: impl FnOnce(&T) -> PathBuf,
) -> io::Result<T> {
    let mut open = open();
    let Some(files) = open.as_mut() else {
        return Err(io::Error::other("the program is ending"));
    };
    let made = make()?;
    files.unfinished.push(path(&made));
    Ok(made)
}

/// Remembers folders that were made, each behind those above it.
pub(crate) fn made(folders: Vec<PathBuf>) {
    if let Some(files) = open().as_mut() {
        files.folders.extend(folders);
        let surplus = files.folders.len().saturating_sub(MOST);
        files.folders.drain(..surplus);
    }
}

/// Removes the folders that this program made for output and in which nothing was written: for a run that failed.
pub fn remove_empty_folders() {
    let folders = open().as_mut().map(|files| std::mem::take(&mut files.folders));
    Open::remove_empty(folders.unwrap_or_default());
}

/// Removes every file that is being written; whoever begins or finishes one after this gets an error. For a program that has to end now.
/// Returns the files that were finished before, the last few hundred at most.
pub fn stop_writing() -> Vec<PathBuf> {
    let Some(Open { unfinished, finished, folders }) = open().take() else { return Vec::new() };
    for path in unfinished {
        let _ = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
    }
    Open::remove_empty(folders);
    finished
}

/// The name of a temporary file or folder, remembered as long as there may be one.
#[derive(Debug)]
pub(crate) struct Remembered(pub PathBuf);

impl Drop for Remembered {
    fn drop(&mut self) {
        if let Some(files) = open().as_mut() {
            files.unfinished.retain(|other| *other != self.0);
        }
    }
}

/// An empty folder among the system's temporary files. It disappears when it is dropped, and with [`stop_writing`].
#[derive(Debug)]
pub struct ScratchFolder {
    // Dropped in this order: the folder is gone before it is forgotten.
    folder: TempDir,
    _named: Remembered,
}

impl ScratchFolder {
    /// Makes one, which nobody else may read.
    ///
    /// # Errors
    /// [`IoError::Write`] when the system's folder of temporary files accepts none.
    pub fn create() -> Result<Self, IoError> {
        let make = || tempfile::Builder::new().prefix("truepose-").tempdir();
        let folder = begun(make, |made| made.path().to_path_buf()).map_err(|error| IoError::Write {
            file: std::env::temp_dir(),
            message: crate::error::reason(&error),
        })?;
        let named = Remembered(folder.path().to_path_buf());
        Ok(ScratchFolder { folder, _named: named })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}
