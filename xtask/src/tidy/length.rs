//! One idea, one file: above 400 lines of code it may hold two, above 500 it does.

use super::{Finding, SourceFile};

const WARN_ABOVE: usize = 400;
const FAIL_ABOVE: usize = 500;

/// Counts the lines in front of the tests at a file's bottom; a file that is all tests is not counted.
pub fn check(files: &[SourceFile]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in files.iter().filter(|f| f.path.ends_with(".rs") && !is_all_tests(&f.path)) {
        let lines = lines_of_code(&file.text);
        let text = format!("{} has {lines} lines in front of its tests", file.path);
        if lines > FAIL_ABOVE {
            findings.push(Finding::Fault(format!("{text}; {FAIL_ABOVE} is the ceiling: split it")));
        } else if lines > WARN_ABOVE {
            findings.push(Finding::Warning(format!("{text}; does it hold two ideas?")));
        }
    }
    findings
}

fn is_all_tests(path: &str) -> bool {
    path.starts_with("tests/") || path.contains("/tests/") || path.ends_with("/tests.rs")
}

fn lines_of_code(text: &str) -> usize {
    text.lines().take_while(|line| *line != "#[cfg(test)]").count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_says(path: &str, code: usize, tests: usize, expected: usize, faults: bool) {
        let text = format!("{}#[cfg(test)]\n{}", "x\n".repeat(code), "y\n".repeat(tests));
        let found = check(&[SourceFile { path: path.into(), text }]);
        assert_eq!(found.len(), expected, "{found:?}");
        assert_eq!(found.iter().any(|f| matches!(f, Finding::Fault(_))), faults);
    }

    #[test]
    fn only_code_counts() {
        check_says("crates/a/src/b.rs", 400, 900, 0, false);
        check_says("crates/a/src/b.rs", 401, 0, 1, false);
        check_says("crates/a/src/b.rs", 501, 0, 1, true);
        check_says("crates/a/tests/b.rs", 900, 0, 0, false);
        check_says("notes.md", 900, 0, 0, false);
    }
}
