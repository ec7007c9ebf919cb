//! One idea, one file: 400 lines are room for it and its tests.

use super::{Finding, SourceFile};

const MOST: usize = 400;

/// Counts lines; a file that is all tests is not counted.
pub fn check(files: &[SourceFile]) -> Vec<Finding> {
    let counted = files.iter().filter(|file| file.path.ends_with(".rs") && !is_all_tests(&file.path));
    let mut findings = Vec::new();
    for file in counted {
        let lines = file.text.lines().count();
        if lines > MOST {
            let text = format!("{} has {lines} lines; {MOST} is the ceiling: split it", file.path);
            findings.push(Finding(text));
        }
    }
    findings
}

fn is_all_tests(path: &str) -> bool {
    path.starts_with("tests/") || path.contains("/tests/") || path.ends_with("/tests.rs")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_says(path: &str, lines: usize, expected: &[Finding]) {
        let found = check(&[SourceFile { path: path.into(), text: "x\n".repeat(lines) }]);
        assert_eq!(found, expected);
    }

    #[test]
    fn files_of_more_than_400_lines_fail() {
        let fault = "crates/a/src/b.rs has 401 lines; 400 is the ceiling: split it";
        check_says("crates/a/src/b.rs", 400, &[]);
        check_says("crates/a/src/b.rs", 401, &[Finding(fault.into())]);
        check_says("crates/a/tests/b.rs", 900, &[]);
        check_says("crates/a/src/b/tests.rs", 900, &[]);
        check_says("notes.md", 900, &[]);
    }
}
