//! Files are written whole or not at all.
//!
//! The bytes go to a temporary file in the same folder, which is flushed to the disk and then renamed. On any
//! error the temporary file disappears and an existing file stays as it was. What is no regular file (a pipe,
//! a terminal, `/dev/stdout`) is written directly.

use crate::IoError;
use crate::error::reason;
use crate::unfinished::{Remembered, begun, finished, made};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes a file whole or not at all.
///
/// # Errors
/// [`IoError::Write`] when the folder is missing or not writable, or the disk is full.
pub fn write_whole(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), IoError> {
    let path = path.as_ref();
    let mut file = WholeFile::create(path)?;
    file.write_all(bytes).map_err(|error| refused(path, &error))?;
    file.finish()
}

/// Makes sure that a file can be written later: its folder exists and accepts files.
///
/// Long work calls this first, so that it does not fail at its very end.
///
/// # Errors
/// [`IoError::Write`] as [`write_whole`] would give it.
pub fn check_writable(path: impl AsRef<Path>) -> Result<(), IoError> {
    WholeFile::create(path.as_ref()).map(drop)
}

/// Makes a folder for output, with the folders above it; one that exists already is fine. A run that fails then removes what stays empty of
/// them ([`remove_empty_folders`](crate::remove_empty_folders)).
///
/// # Errors
/// [`IoError::Write`] when it cannot be made, or a file has its name.
pub fn make_folder(path: impl AsRef<Path>) -> Result<(), IoError> {
    let path = path.as_ref();
    let missing = path.ancestors().take_while(|above| !above.as_os_str().is_empty() && !above.exists());
    let mut missing: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
    missing.reverse();
    let result = fs::create_dir_all(path);
    made(missing);
    result.map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists | io::ErrorKind::NotADirectory => IoError::Write {
            file: path.into(),
            message: "a file stands where a folder is needed; name another folder".into(),
        },
        _ => refused(path, &error),
    })
}

/// A file that is being written and appears under its name only with [`WholeFile::finish`].
#[derive(Debug)]
pub struct WholeFile {
    path: PathBuf,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    Renamed { writer: BufWriter<NamedTempFile>, onto: PathBuf, named: Remembered },
    Direct(BufWriter<File>),
}

/// Whether a path names a device or an open descriptor, as `/dev/stdout` does. Folders in `/dev` are folders: `/dev/shm` holds files.
pub(crate) fn is_device(path: &Path) -> bool {
    path.parent() == Some(Path::new("/dev")) || path.starts_with("/dev/fd") || path.starts_with("/proc")
}

impl WholeFile {
    /// Begins a file.
    ///
    /// # Errors
    /// [`IoError::Write`] when the folder is missing or not writable.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, IoError> {
        let path = path.as_ref();
        let existing = match fs::metadata(path) {
            Ok(metadata) => Some(metadata),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) if error.kind() == io::ErrorKind::NotADirectory => {
                return Err(IoError::Write {
                    file: path.into(),
                    message: "a file stands where a folder is needed; name another folder".into(),
                });
            }
            Err(error) => return Err(refused(path, &error)),
        };
        if existing.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(IoError::Write { file: path.into(), message: "it is a folder; name a file".into() });
        }
        let regular = existing.as_ref().is_none_or(fs::Metadata::is_file) && !is_device(path);
        if !regular {
            let file = OpenOptions::new().append(true).open(path).map_err(|error| refused(path, &error))?;
            return Ok(WholeFile { path: path.into(), sink: Sink::Direct(BufWriter::new(file)) });
        }
        // A link keeps pointing to its file, which is replaced where it lies.
        let onto = if existing.is_some() {
            fs::canonicalize(path).map_err(|error| refused(path, &error))?
        } else {
            path.to_path_buf()
        };
        if existing.as_ref().is_some_and(|metadata| metadata.permissions().readonly()) {
            return Err(IoError::Write {
                file: path.into(),
                message: "the existing file is read-only".into(),
            });
        }
        let folder = match onto.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let make = || begin(folder, existing.as_ref());
        let temporary =
            begun(make, |file| file.path().to_path_buf()).map_err(|error| match error.kind() {
                io::ErrorKind::NotFound => IoError::Write {
                    file: path.into(),
                    message: format!("there is no folder `{}`; create it first", folder.display()),
                },
                io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => IoError::Write {
                    file: path.into(),
                    message: format!("the folder `{}` is not writable", folder.display()),
                },
                io::ErrorKind::NotADirectory => IoError::Write {
                    file: path.into(),
                    message: format!("`{}` is not a folder", folder.display()),
                },
                _ => refused(path, &error),
            })?;
        let named = Remembered(temporary.path().to_path_buf());
        let writer = BufWriter::with_capacity(1 << 16, temporary);
        Ok(WholeFile { path: path.into(), sink: Sink::Renamed { writer, onto, named } })
    }

    /// Puts the file under its name.
    ///
    /// # Errors
    /// [`IoError::Write`] when the disk is full or the folder does not accept the file; nothing is left then.
    pub fn finish(self) -> Result<(), IoError> {
        let mut together = WholeFiles::default();
        together.push(self)?;
        together.finish()
    }

    /// Everything on the disk, under no name yet.
    fn ready(self) -> Result<Option<Ready>, IoError> {
        let WholeFile { path, sink } = self;
        match sink {
            Sink::Direct(mut writer) => writer.flush().map(|()| None).map_err(|error| refused(&path, &error)),
            Sink::Renamed { writer, onto, named } => {
                let temporary = writer.into_inner().map_err(|error| refused(&path, error.error()))?;
                temporary.as_file().sync_all().map_err(|error| refused(&path, &error))?;
                Ok(Some(Ready { path, onto, temporary, _named: named }))
            }
        }
    }

    /// Turns an error of [`Write`] into one that names the file.
    pub fn refused(&self, error: &io::Error) -> IoError {
        refused(&self.path, error)
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.sink {
            Sink::Renamed { writer, .. } => writer.write(bytes),
            Sink::Direct(writer) => writer.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Renamed { writer, .. } => writer.flush(),
            Sink::Direct(writer) => writer.flush(),
        }
    }
}

/// A file with all its bytes.
#[derive(Debug)]
struct Ready {
    path: PathBuf,
    onto: PathBuf,
    temporary: NamedTempFile,
    _named: Remembered,
}

/// Files that appear together: each is complete on the disk before the first one gets its name, so that a full disk leaves none of them.
#[derive(Debug, Default)]
pub struct WholeFiles(Vec<Ready>);

impl WholeFiles {
    /// Adds a file with these bytes.
    ///
    /// # Errors
    /// [`IoError::Write`] as [`write_whole`] gives it.
    pub fn add(&mut self, path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), IoError> {
        let path = path.as_ref();
        let mut file = WholeFile::create(path)?;
        file.write_all(bytes).map_err(|error| refused(path, &error))?;
        self.push(file)
    }

    /// Adds a file that has all its bytes.
    ///
    /// # Errors
    /// [`IoError::Write`] when the disk is full.
    pub fn push(&mut self, file: WholeFile) -> Result<(), IoError> {
        self.0.extend(file.ready()?);
        Ok(())
    }

    /// Puts all files under their names, at once for a program that is ended meanwhile ([`stop_writing`](crate::stop_writing)).
    ///
    /// # Errors
    /// [`IoError::Write`] when a folder does not accept a file; those behind it are not put either.
    pub fn finish(self) -> Result<(), IoError> {
        let Some(first) = self.0.first().map(|file| file.path.clone()) else { return Ok(()) };
        let names: Vec<PathBuf> = self.0.iter().map(|file| file.path.clone()).collect();
        let mut folders: Vec<PathBuf> = self.0.iter().filter_map(|f| Some(f.onto.parent()?.into())).collect();
        folders.dedup();
        let mut named = Vec::with_capacity(names.len());
        let put = || {
            for Ready { path, onto, temporary, _named } in self.0 {
                temporary.persist(&onto).map_err(|error| refused(&path, &error.error))?;
                // Forgotten after the lock is open again.
                named.push(_named);
            }
            Ok(())
        };
        let stopped = || IoError::Write { file: first, message: "the program is ending".into() };
        finished(names.into_iter(), put, stopped)?;
        // The renames become durable with their folders; where that cannot be asked for, they are late only.
        for folder in folders.iter().filter_map(|folder| File::open(folder).ok()) {
            let _ = folder.sync_all();
        }
        Ok(())
    }
}

fn begin(folder: &Path, existing: Option<&fs::Metadata>) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".truepose-").suffix(".partial");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666)); // less the umask, as for any new file
    }
    let temporary = builder.tempfile_in(folder)?;
    if let Some(metadata) = existing {
        temporary.as_file().set_permissions(metadata.permissions())?;
    }
    Ok(temporary)
}

fn refused(path: &Path, error: &io::Error) -> IoError {
    IoError::Write { file: path.into(), message: reason(error) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.json");
        write_whole(&path, b"old").unwrap();
        let mut file = WholeFile::create(&path).unwrap();
        file.write_all(b"new and unfin").unwrap();
        drop(file);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["out.json"]);
        write_whole(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        check_writable(&path).unwrap();
        make_folder(folder.path()).unwrap();
        let message = make_folder(&path).unwrap_err().to_string();
        assert!(
            message.ends_with("a file stands where a folder is needed; name another folder"),
            "{message}"
        );
        assert_eq!(names(folder.path()), ["out.json"]);
    }

    #[test]
    fn files_appear_together_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        write_whole(at("a"), b"old").unwrap();
        let mut files = WholeFiles::default();
        files.add(at("a"), b"new").unwrap();
        files.add(at("b"), b"new").unwrap();
        assert_eq!(fs::read(at("a")).unwrap(), b"old");
        assert!(!at("b").exists());
        if Path::new("/dev/full").exists() {
            assert!(files.add("/dev/full", b"x").is_err());
        }
        drop(files);
        assert_eq!(
            (fs::read(at("a")).unwrap(), names(folder.path())),
            (b"old".to_vec(), vec!["a".to_owned()])
        );
        let mut files = WholeFiles::default();
        files.add(at("a"), b"new").unwrap();
        files.add(at("b"), b"new").unwrap();
        files.finish().unwrap();
        assert_eq!(names(folder.path()), ["a", "b"]);
        assert_eq!(fs::read(at("a")).unwrap(), b"new");
    }

    #[test]
    fn a_missing_folder_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("no/out.json");
        let message = write_whole(&path, b"x").unwrap_err().to_string();
        let expected = format!(
            "{}: cannot be written: there is no folder `{}`; create it first",
            path.display(),
            folder.path().join("no").display()
        );
        assert_eq!(message, expected);
        let message = write_whole(folder.path(), b"x").unwrap_err().to_string();
        assert!(message.ends_with("cannot be written: it is a folder; name a file"), "{message}");
    }

    #[cfg(unix)]
    #[test]
    fn special_files_are_written_directly() {
        let devices = ["/dev/null", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];
        assert!(devices.iter().all(|path| is_device(Path::new(path))));
        assert!(!is_device(Path::new("/dev/shm/fit.json")) && !is_device(Path::new("fit.json")));
        write_whole("/dev/null", b"x").unwrap();
        if Path::new("/dev/full").exists() {
            let message = write_whole("/dev/full", b"x").unwrap_err().to_string();
            assert_eq!(message, "/dev/full: cannot be written: no space left on device");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_that_is_not_writable_is_reported() {
        // Whoever may do anything can write everywhere except where nobody can.
        let path = Path::new("/proc/truepose-out.json");
        if Path::new("/proc/self").exists() {
            let message = write_whole(path, b"x").unwrap_err().to_string();
            assert!(message.starts_with("/proc/truepose-out.json: cannot be written: "), "{message}");
        }
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let closed = folder.path().join("closed");
        fs::create_dir(&closed).unwrap();
        fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
        let path = closed.join("out.json");
        match write_whole(&path, b"x") {
            Ok(()) => {} // a superuser is not held up by permissions
            Err(error) => assert_eq!(
                error.to_string(),
                format!(
                    "{}: cannot be written: the folder `{}` is not writable",
                    path.display(),
                    closed.display()
                )
            ),
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_keeps_pointing_to_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        write_whole(&real, b"1").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write_whole(&link, b"2").unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"2");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        let ring = folder.path().join("ring");
        std::os::unix::fs::symlink(&ring, &ring).unwrap();
        assert!(write_whole(&ring, b"3").is_err());
    }
}
