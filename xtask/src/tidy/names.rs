//! A file called `util` has no subject: what it holds belongs beside its caller.

use super::{Finding, SourceFile};

const NAMELESS: [&str; 5] = ["util", "utils", "common", "helpers", "misc"];

/// Looks at the name of every file and folder.
pub fn check(files: &[SourceFile]) -> Vec<Finding> {
    files
        .iter()
        .filter(|file| {
            file.path.split('/').any(|part| NAMELESS.contains(&part.split('.').next().unwrap_or(part)))
        })
        .map(|file| Finding(format!("{}: name it after what it holds", file.path)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_and_files_are_looked_at_and_whole_names_only() {
        let files = ["a/util.rs", "a/utils/b.rs", "helpers/x.py", "a/utility.rs", "common.toml", "a/b.rs"]
            .map(|path| SourceFile { path: path.into(), text: String::new() });
        let found = check(&files);
        assert_eq!(found.len(), 4, "{found:?}");
    }
}
