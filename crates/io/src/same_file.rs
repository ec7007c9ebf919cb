//! Whether two paths lead to one file, so that nothing overwrites what it was made from.

use std::path::{Path, PathBuf};

/// Whether both are one and the same file, or would be once it is written; links are followed. Devices and pipes are never the
/// same: writing to one overwrites nothing.
pub fn same_file(a: impl AsRef<Path>, b: impl AsRef<Path>) -> bool {
    let (a, b) = (a.as_ref(), b.as_ref());
    let special = |path: &Path| path.metadata().is_ok_and(|m| !m.is_file() && !m.is_dir());
    !special(a) && !special(b) && whole(a) == whole(b)
}

/// From the root, links followed; of a file that does not exist yet, its folder's.
fn whole(path: &Path) -> PathBuf {
    let folder = || {
        let above = path.parent().filter(|above| !above.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some(above.canonicalize().ok()?.join(path.file_name()?))
    };
    path.canonicalize().ok().or_else(folder).unwrap_or_else(|| path.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_one_file_are_told_as_such() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a.csv"), "").unwrap();
        std::fs::create_dir(at("deep")).unwrap();
        assert!(same_file(at("a.csv"), at("deep/../a.csv")));
        assert!(same_file(at("new.csv"), at("deep/../new.csv")));
        assert!(same_file(at("deep"), at("deep/")));
        assert!(!same_file(at("a.csv"), at("b.csv")));
        assert!(!same_file(at("a.csv"), at("deep/a.csv")));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("a.csv", at("link.csv")).unwrap();
            assert!(same_file(at("a.csv"), at("link.csv")));
            assert!(!same_file("/dev/null", "/dev/null"));
        }
    }
}
