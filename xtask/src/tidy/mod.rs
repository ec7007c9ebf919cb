//! `cargo xtask tidy`: the rules of the house that no other tool knows.
//!
//! The tree has two workspaces, the project and `lab`; what is about manifests is checked in both. Each check reads the tree and returns what it found; nothing is changed. A *fault* fails the run, a
//! *warning* does not.

mod layers;
mod length;
mod links;
mod manifests;
mod minimal;
mod modules;
mod names;
mod supply;
mod unused;
mod words;

use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A fault that a check has found: what is wrong, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding(pub String);

/// A file under version control: its path from the root with `/`, and its text.
#[derive(Debug, Clone)]
pub struct SourceFile {
    /// Path from the root.
    pub path: String,
    /// Its text; empty for a file that is not UTF-8.
    pub text: String,
}

/// Runs every check.
pub fn run(root: &Path) -> Result<()> {
    let files = tracked_files(root)?;
    let deny = text(root, "deny.toml")?;
    let here = root.to_str().context("the path of the repository is not UTF-8")?;
    let manifest = text(root, "Cargo.toml")?;
    let table = layers::Table::from_manifest(&manifest)?;
    let metadata = metadata_of(root, &["--no-deps"])?;
    let mut findings = layers::check(&table, &layers::packages(&metadata)?);
    for (folder, metadata) in [(root.to_path_buf(), metadata), lab(root)?] {
        let manifest = text(&folder, "Cargo.toml")?;
        findings.extend(manifests::check(here, &metadata, &files)?);
        findings.extend(supply::check(
            &metadata_of(&folder, &["--all-features", "--filter-platform", "x86_64-unknown-linux-gnu"])?,
            &deny,
        )?);
        findings.extend(minimal::check(&manifest, &text(&folder, "Cargo.lock")?)?);
        findings.extend(unused::check(here, &metadata, &manifest, &files)?);
    }
    findings.extend(length::check(&files));
    findings.extend(modules::check(&files));
    findings.extend(links::check(&files));
    findings.extend(names::check(&files));
    findings.extend(words::check(&files));

    for Finding(text) in &findings {
        eprintln!("fault: {text}");
    }
    let faults = findings.len();
    if faults > 0 {
        bail!("tidy found {faults} fault{}", if faults == 1 { "" } else { "s" });
    }
    println!("tidy: {} files, {} crates, no faults", files.len(), table.len());
    Ok(())
}

/// Tracked files and new ones that are not ignored.
fn tracked_files(root: &Path) -> Result<Vec<SourceFile>> {
    let output = Command::new("git")
        .args(["ls-files", "--cached", "--others", "--exclude-standard", "-z"])
        .current_dir(root)
        .output()
        .context("cannot start git")?;
    if !output.status.success() {
        bail!("git ls-files failed: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    let listed = String::from_utf8(output.stdout).context("a path is not UTF-8")?;
    let mut files: Vec<SourceFile> = Vec::new();
    for path in listed.split('\0').filter(|path| !path.is_empty()) {
        // A file that was deleted but is still in the index has nothing to be checked.
        if let Ok(bytes) = std::fs::read(root.join(path)) {
            files.push(SourceFile { path: path.into(), text: String::from_utf8(bytes).unwrap_or_default() });
        }
    }
    files.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(files)
}

/// The folder of the second workspace, and its own crates. They may depend on every crate, and no crate of the project on one of them:
/// its table of layers has none.
fn lab(root: &Path) -> Result<(PathBuf, serde_json::Value)> {
    let folder = root.join("lab");
    let metadata = metadata_of(&folder, &["--no-deps"])?;
    Ok((folder, metadata))
}

/// The text of a file.
fn text(folder: &Path, name: &str) -> Result<String> {
    let path = folder.join(name);
    std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))
}

/// `cargo metadata` of the workspace in a folder, with these options.
fn metadata_of(root: &Path, options: &[&str]) -> Result<serde_json::Value> {
    let output = Command::new("cargo")
        .args(["metadata", "--format-version", "1", "--locked"])
        .args(options)
        .current_dir(root)
        .output()
        .context("cannot start cargo")?;
    if !output.status.success() {
        bail!("cargo metadata failed: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    serde_json::from_slice(&output.stdout).context("cargo metadata is not JSON")
}
