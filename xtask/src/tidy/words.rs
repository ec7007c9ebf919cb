//! Words that must not be committed: marks of unfinished work, and paths of somebody's machine.

use super::{Finding, SourceFile};

/// In Rust files. Written in two halves, so that this file passes its own check.
const MARKS: [&str; 5] = [
    concat!("to", "do!("),
    concat!("unimple", "mented!("),
    concat!("#[ig", "nore"),
    concat!("FIX", "ME"),
    concat!("XX", "X"),
];

/// In every text file.
const PATHS: [&str; 3] = [concat!("/wo", "rk/"), concat!("/ro", "ot/"), concat!("/tm", "p/")];

/// Looks at every line.
pub fn check(files: &[SourceFile]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in files {
        for (index, line) in file.text.lines().enumerate() {
            let at = format!("{}:{}", file.path, index + 1);
            if file.path.ends_with(".rs")
                && let Some(mark) = MARKS.iter().find(|mark| line.contains(**mark))
            {
                findings.push(Finding(format!("{at}: `{mark}` is unfinished work")));
            }
            if let Some(path) = PATHS.iter().find(|path| names_a_machine_path(line, path)) {
                findings.push(Finding(format!("{at}: `{path}` is a path of one machine")));
            }
        }
    }
    findings
}

/// True where the path begins, not where it is the middle of a longer one (`https://x.org/work/`, `a/work/b`).
fn names_a_machine_path(line: &str, path: &str) -> bool {
    line.match_indices(path).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        !before.is_some_and(|c| c.is_alphanumeric() || matches!(c, '.' | '-' | '_' | '}' | '~'))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_says(path: &str, text: &str, expected: usize) {
        let found = check(&[SourceFile { path: path.into(), text: text.into() }]);
        assert_eq!(found.len(), expected, "{found:?}");
    }

    #[test]
    fn unfinished_work_is_found_in_rust_only() {
        for mark in MARKS {
            check_says("a.rs", &format!("fn f() {{}}\n// {mark}"), 1);
            check_says("a.md", mark, 0);
        }
    }

    #[test]
    fn machine_paths_are_found_everywhere_but_not_inside_longer_ones() {
        for path in PATHS {
            check_says("a.md", &format!("see {path}x"), 1);
            check_says("a.md", &format!("see https://example.org{path}x"), 0);
            check_says("a.toml", &format!("f = \"{path}\""), 1);
        }
    }
}
