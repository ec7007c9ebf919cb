//! Every crate has its licence, and a README that is its front page.

use super::{Finding, SourceFile};
use anyhow::{Context, Result};

const LICENCE: &str = "MIT OR Apache-2.0";

/// Looks at each crate's licence field, its README, and whether the crate's page includes it; and at the
/// licences' texts at the root.
pub fn check(root: &str, metadata: &serde_json::Value, files: &[SourceFile]) -> Result<Vec<Finding>> {
    let mut findings: Vec<Finding> = ["LICENSE-MIT", "LICENSE-APACHE"]
        .iter()
        .filter(|name| !files.iter().any(|file| file.path == **name))
        .map(|name| Finding(format!("{name} is missing at the root")))
        .collect();
    for package in metadata["packages"].as_array().context("cargo metadata lists no packages")? {
        let name = package["name"].as_str().context("a package without a name")?;
        if package["license"].as_str() != Some(LICENCE) {
            findings.push(Finding(format!("{name}: its licence has to be `{LICENCE}`")));
        }
        let manifest = package["manifest_path"].as_str().context("a package without a manifest")?;
        let folder = manifest.strip_prefix(root).and_then(|p| p.strip_suffix("Cargo.toml"));
        let folder = folder.context("a crate outside the repository")?.trim_start_matches('/');
        if folder.starts_with("crates/") || folder.starts_with("lab/") {
            findings.extend(front_page(name, folder, files));
        }
    }
    Ok(findings)
}

fn front_page(name: &str, folder: &str, files: &[SourceFile]) -> Option<Finding> {
    if !files.iter().any(|file| file.path == format!("{folder}README.md")) {
        return Some(Finding(format!("{name}: {folder}README.md is missing")));
    }
    let includes = ["src/lib.rs", "src/main.rs"].iter().any(|page| {
        files.iter().any(|file| {
            file.path == format!("{folder}{page}") && file.text.contains(r#"include_str!("../README.md")"#)
        })
    });
    (!includes)
        .then(|| Finding(format!("{name}: begin its page with #![doc = include_str!(\"../README.md\")]")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_says(licence: &str, files: &[(&str, &str)], expected: usize) {
        let metadata = serde_json::json!({"packages": [
            {"name": "a", "license": licence, "manifest_path": "/x/crates/a/Cargo.toml"}]});
        let licences = [("LICENSE-MIT", ""), ("LICENSE-APACHE", "")];
        let files: Vec<SourceFile> = files
            .iter()
            .chain(&licences)
            .map(|(path, text)| SourceFile { path: path.to_string(), text: text.to_string() })
            .collect();
        let found = check("/x", &metadata, &files).expect("metadata");
        assert_eq!(found.len(), expected, "{found:?}");
    }

    #[test]
    fn licence_and_front_page_are_needed() {
        let page = ("crates/a/src/lib.rs", "#![doc = include_str!(\"../README.md\")]");
        let readme = ("crates/a/README.md", "# a");
        check_says(LICENCE, &[page, readme], 0);
        check_says("GPL-3.0", &[page, readme], 1);
        check_says(LICENCE, &[page], 1);
        check_says(LICENCE, &[("crates/a/src/lib.rs", "//! a"), readme], 1);
    }
}
