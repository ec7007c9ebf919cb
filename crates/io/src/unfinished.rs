//! Files that are being written, so that a program that has to end at once leaves none of them behind.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

static OPEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn open() -> MutexGuard<'static, Vec<PathBuf>> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes a temporary file and remembers it, both or neither.
pub(crate) fn begun<T, E>(
    make: impl FnOnce() -> Result<T, E>,
    path: impl FnOnce(&T) -> PathBuf,
) -> Result<T, E> {
    let mut open = open();
    let made = make()?;
    open.push(path(&made));
    Ok(made)
}

/// The file is there under its name, or is gone.
pub(crate) fn ended(path: &Path) {
    open().retain(|other| other != path);
}

/// Removes every file that is being written. Whoever begins another one after this waits for ever: the program has to end now.
pub fn discard_unfinished() {
    let open = open();
    for path in open.iter() {
        let _ = std::fs::remove_file(path);
    }
    std::mem::forget(open);
}
