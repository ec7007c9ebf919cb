//! Links in Markdown files lead to a file that is there, and to a heading that it has.

use super::{Finding, SourceFile};
use std::collections::{BTreeMap, BTreeSet};

/// Follows every relative link; what begins with a scheme (`https:`) or names an item of Rust (`crate::a`) is left alone.
pub fn check(files: &[SourceFile]) -> Vec<Finding> {
    let paths: BTreeSet<&str> = files.iter().map(|file| file.path.as_str()).collect();
    let pages: BTreeMap<&str, Vec<String>> = files
        .iter()
        .filter(|file| file.path.ends_with(".md"))
        .map(|file| (file.path.as_str(), anchors(&file.text)))
        .collect();
    let mut findings = Vec::new();
    for page in files.iter().filter(|file| file.path.ends_with(".md")) {
        for (line, target) in links(&page.text) {
            let (to, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let path = if to.is_empty() { Some(page.path.clone()) } else { resolved(&page.path, to) };
            let exists = |path: &String| {
                let folder = format!("{}/", path.trim_end_matches('/'));
                path.is_empty()
                    || paths.contains(path.as_str())
                    || paths.iter().any(|file| file.starts_with(&folder))
            };
            let at = format!("{}:{line}", page.path);
            let Some(path) = path.filter(exists) else {
                findings.push(Finding(format!("{at}: {target} leads to no file of the project")));
                continue;
            };
            let headings = pages.get(path.as_str());
            if !anchor.is_empty() && headings.is_some_and(|all| !all.iter().any(|known| known == anchor)) {
                findings.push(Finding(format!("{at}: {path} has no heading for #{anchor}")));
            }
        }
    }
    findings
}

/// Lines outside of code blocks, with their numbers from 1.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut fenced = false;
    text.lines().enumerate().filter_map(move |(index, line)| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        (!fenced && !fence).then_some((index + 1, line))
    })
}

/// Relative targets with their lines: `](target)` and `[name]: target`.
fn links(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in prose(text) {
        let line = without_code(line);
        for (at, _) in line.match_indices("](") {
            let rest = &line[at + 2..];
            found.push((number, rest[..rest.find([')', ' ']).unwrap_or(rest.len())].to_owned()));
        }
        if let Some((_, target)) = line.strip_prefix('[').and_then(|rest| rest.split_once("]: ")) {
            found.push((number, target.trim().to_owned()));
        }
    }
    found.retain(|(_, target)| !target.is_empty() && !target.contains(':'));
    found
}

/// A line without what stands between backticks.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect()
}

/// A path from the root, given from beside a file; none where it leaves the project.
fn resolved(from: &str, to: &str) -> Option<String> {
    let mut parts: Vec<&str> = from.split('/').collect();
    parts.pop();
    for part in to.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()?),
            _ => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

/// The anchors of a page's headings, as GitHub and docs.rs form them.
fn anchors(text: &str) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for (_, line) in prose(text) {
        let heading = line.trim_start_matches('#');
        if heading.len() == line.len() || !heading.starts_with(' ') {
            continue;
        }
        // The text of a link is its name.
        let mut words = String::new();
        let mut rest = heading.trim();
        while let Some((before, behind)) = rest.split_once("](") {
            words += before;
            rest = behind.split_once(')').map_or("", |(_, behind)| behind);
        }
        words += rest;
        let lower = words.to_lowercase();
        let kept = lower.chars().filter_map(|c| match c {
            ' ' => Some('-'),
            c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
            _ => None,
        });
        let anchor: String = kept.collect();
        let before = all.iter().filter(|known| **known == anchor).count();
        all.push(if before == 0 { anchor } else { format!("{anchor}-{before}") });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_says(text: &str, expected: &[&str]) {
        let b = "# The `b`: one, two\n## [C](a.md)\n";
        let files = [("docs/a.md", text), ("docs/b.md", b), ("crates/x/src/lib.rs", "")]
            .map(|(path, text)| SourceFile { path: path.into(), text: text.into() });
        let expected: Vec<Finding> = expected.iter().map(|text| Finding(text.to_string())).collect();
        assert_eq!(check(&files), expected);
    }

    #[test]
    fn links_that_lead_somewhere_pass() {
        check_says(
            "# A b\n[b](b.md#the-b-one-two) [c](b.md#c) [here](#a-b) ![l](../crates/x/src/lib.rs) [f](../crates)",
            &[],
        );
        check_says("[w](https://example.org/x#y) [i](crate::Y) `[n](no.md)`\n```\n[n](no.md)\n```", &[]);
    }

    #[test]
    fn links_that_lead_nowhere_are_found_with_their_line() {
        check_says("\n[n](no.md)", &["docs/a.md:2: no.md leads to no file of the project"]);
        check_says("[n](../../out.md)", &["docs/a.md:1: ../../out.md leads to no file of the project"]);
        check_says("[n](b.md#d)", &["docs/a.md:1: docs/b.md has no heading for #d"]);
        check_says("[n](#d)", &["docs/a.md:1: docs/a.md has no heading for #d"]);
    }
}
