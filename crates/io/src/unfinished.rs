//! Files that are being written, so that a program that has to end at once leaves none of them behind.

use crate::IoError;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::TempDir;

/// Temporary files and folders; none once writing was stopped.
static OPEN: Mutex<Option<Vec<PathBuf>>> = Mutex::new(Some(Vec::new()));

fn open() -> MutexGuard<'static, Option<Vec<PathBuf>>> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
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
    files.push(path(&made));
    Ok(made)
}

/// Removes every file that is being written; whoever begins or finishes one after this gets an error. For a program that has to end now.
pub fn stop_writing() {
    for path in open().take().into_iter().flatten() {
        let _ = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
    }
}

/// The name of a temporary file or folder, remembered as long as there may be one.
#[derive(Debug)]
pub(crate) struct Remembered(pub PathBuf);

impl Drop for Remembered {
    fn drop(&mut self) {
        if let Some(files) = open().as_mut() {
            files.retain(|other| *other != self.0);
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
