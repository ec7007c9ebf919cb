//! Files that are being written, so that a program that has to end at once leaves none of them behind.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Temporary files; none once writing was stopped.
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

/// The file is there under its name, or is gone.
pub(crate) fn ended(path: &Path) {
    if let Some(files) = open().as_mut() {
        files.retain(|other| other != path);
    }
}

/// Removes every file that is being written; whoever begins or finishes one after this gets an error. For a program that has to end now.
pub fn stop_writing() {
    for path in open().take().into_iter().flatten() {
        let _ = std::fs::remove_file(path);
    }
}
