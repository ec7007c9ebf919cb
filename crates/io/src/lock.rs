//! Advisory locks on what a run writes, so that two runs side by side neither mix their files nor lose what the other has added.
//!
//! A file is replaced where it is written, and a lock on it would stay with the old one: the lock is on a file of its own beside it,
//! `.NAME.lock`, or in a folder, `.lock`. It disappears with the lock; one that was left behind by a run that was killed locks nothing.

use crate::IoError;
use crate::unfinished::{Remembered, begun};
use crate::write_whole::is_device;
use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

/// What is done where another run has the lock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occupied {
    /// The run is refused.
    Refuse,
    /// It waits for the other one.
    Wait,
}

/// A lock, until it is dropped.
#[derive(Debug)]
pub struct FileLock {
    file: File,
    named: Remembered,
}

impl FileLock {
    /// The lock of a file, or of a folder that is there. None where nothing can be locked: what is no regular file, in a folder that
    /// does not exist or that cannot be written, which writing reports.
    ///
    /// # Errors
    /// When another run has it and it is not waited for, or the program is ending.
    pub fn of(path: impl AsRef<Path>, occupied: Occupied) -> Result<Option<Self>, IoError> {
        let path = path.as_ref();
        let Some(beside) = beside(path) else { return Ok(None) };
        let refused = |message: String| IoError::Write { file: path.into(), message };
        loop {
            let opened = OpenOptions::new().create(true).truncate(false).write(true).open(&beside);
            let Ok(file) = opened else { return Ok(None) };
            match (occupied, file.try_lock()) {
                (_, Ok(())) => {}
                (Occupied::Refuse, Err(TryLockError::WouldBlock)) => {
                    return Err(refused(
                        "another run is writing it; wait until it has ended, or name another".into(),
                    ));
                }
                (Occupied::Wait, Err(TryLockError::WouldBlock)) => {
                    if file.lock().is_err() {
                        return Ok(None);
                    }
                }
                // A file system without locks.
                (_, Err(TryLockError::Error(_))) => return Ok(None),
            }
            // Whoever had the lock before may have removed its file in between.
            if is_still(&file, &beside) {
                let named = begun(|| Ok(()), |()| beside.clone()).map(|()| Remembered(beside));
                let named = named.map_err(|error| refused(crate::error::reason(&error)))?;
                return Ok(Some(FileLock { file, named }));
            }
        }
    }
}

impl Drop for FileLock {
    fn drop(&mut self) {
        // While it is locked: nobody else can have it. Where an open file cannot be told from another of its name, it stays.
        if cfg!(unix) {
            let _ = std::fs::remove_file(&self.named.0);
        }
        let _ = self.file.unlock();
    }
}

/// The file of a lock.
fn beside(path: &Path) -> Option<PathBuf> {
    if is_device(path) {
        return None;
    }
    match path.metadata() {
        Ok(found) if found.is_dir() => Some(path.canonicalize().ok()?.join(".lock")),
        Ok(found) if !found.is_file() => None,
        Ok(_) => hidden(&path.canonicalize().ok()?),
        Err(_) => {
            let above = path.parent().filter(|above| !above.as_os_str().is_empty()).unwrap_or(Path::new("."));
            hidden(&above.canonicalize().ok()?.join(path.file_name()?))
        }
    }
}

fn hidden(path: &Path) -> Option<PathBuf> {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name()?);
    name.push(".lock");
    Some(path.with_file_name(name))
}

/// Whether an open file is the one of this name.
#[cfg(unix)]
fn is_still(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let of = |found: std::io::Result<std::fs::Metadata>| found.ok().map(|found| (found.dev(), found.ino()));
    let (own, named) = (of(file.metadata()), of(path.metadata()));
    own.is_some() && own == named
}

/// Whether an open file is the one of this name: none is ever removed.
#[cfg(not(unix))]
fn is_still(_: &File, _: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_lock_is_refused_until_the_first_is_gone() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("fit.json");
        let first = FileLock::of(&file, Occupied::Refuse).unwrap().unwrap();
        let second =
            FileLock::of(folder.path().join("../").join(folder.path()).join("fit.json"), Occupied::Refuse);
        assert!(second.unwrap_err().to_string().contains("another run is writing it"));
        let other = FileLock::of(folder.path().join("other.json"), Occupied::Refuse).unwrap();
        assert!(other.is_some() && FileLock::of(folder.path(), Occupied::Refuse).unwrap().is_some());
        drop((first, other));
        assert!(FileLock::of(&file, Occupied::Refuse).unwrap().is_some());
        #[cfg(unix)]
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        assert!(FileLock::of("/dev/null", Occupied::Refuse).unwrap().is_none());
    }

    #[test]
    fn whoever_waits_counts_on() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("count");
        std::fs::write(&file, "0").unwrap();
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..20 {
                        let _lock = FileLock::of(&file, Occupied::Wait).unwrap().unwrap();
                        let count: usize = std::fs::read_to_string(&file).unwrap().parse().unwrap();
                        crate::write_whole(&file, (count + 1).to_string().as_bytes()).unwrap();
                    }
                });
            }
        });
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "160");
    }
}
