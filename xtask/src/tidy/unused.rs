//! Dependencies that nobody uses.

use super::{Finding, SourceFile};
use anyhow::{Context, Result};
use std::collections::BTreeSet;

/// Named by nobody and needed: argmin's mathematics for vectors is a feature of this crate, which argmin itself uses.
const NEEDED: [(&str, &str); 1] = [("truepose-solvers", "argmin-math")];

/// Holds `[workspace.dependencies]` against the members, and what each member declares against the names in its files.
pub fn check(metadata: &serde_json::Value, manifest: &str, files: &[SourceFile]) -> Result<Vec<Finding>> {
    let root = metadata["workspace_root"].as_str().context("cargo metadata has no root")?;
    let mut findings = Vec::new();
    let mut declared: BTreeSet<&str> = BTreeSet::new();
    for package in metadata["packages"].as_array().context("cargo metadata lists no packages")? {
        let name = package["name"].as_str().context("a package without a name")?;
        let manifest = package["manifest_path"].as_str().context("a package without a manifest")?;
        let folder = manifest.strip_prefix(root).and_then(|p| p.strip_suffix("Cargo.toml"));
        let folder = folder.context("a crate outside the workspace")?.trim_start_matches('/');
        let named = names(folder, files);
        for dependency in package["dependencies"].as_array().context("a package without dependencies")? {
            let on = dependency["name"].as_str().context("a dependency without a name")?;
            declared.insert(on);
            let word = dependency["rename"].as_str().unwrap_or(on).replace('-', "_");
            if !named.contains(word.as_str()) && !NEEDED.contains(&(name, on)) {
                findings.push(Finding(format!("{name} depends on {on}, which none of its files names")));
            }
        }
    }
    let manifest: toml::Table = manifest.parse().context("Cargo.toml is not TOML")?;
    let shared =
        manifest.get("workspace").and_then(|w| w.get("dependencies")).and_then(toml::Value::as_table);
    for (name, value) in shared.context("Cargo.toml has no [workspace.dependencies]")? {
        let package = value.get("package").and_then(toml::Value::as_str).unwrap_or(name);
        if !declared.contains(package) {
            let text = format!("[workspace.dependencies] lists {name}, which no member depends on");
            findings.push(Finding(text));
        }
    }
    Ok(findings)
}

/// All identifiers in a crate's sources, and in its README, whose examples are tests.
fn names<'a>(folder: &str, files: &'a [SourceFile]) -> BTreeSet<&'a str> {
    files
        .iter()
        .filter(|file| {
            file.path.starts_with(folder) && (file.path.ends_with(".rs") || file.path.ends_with(".md"))
        })
        .flat_map(|file| file.text.split(|c: char| !c.is_alphanumeric() && c != '_'))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_says(shared: &str, dependencies: &[&str], code: &str, expected: &[&str]) {
        let dependencies: Vec<_> =
            dependencies.iter().map(|name| serde_json::json!({"name": name})).collect();
        let metadata = serde_json::json!({"workspace_root": "/x", "packages": [
            {"name": "a", "dependencies": dependencies, "manifest_path": "/x/crates/a/Cargo.toml"}]});
        let manifest = format!("[workspace.dependencies]\n{shared}");
        let files = [("crates/a/src/lib.rs", code), ("crates/b/src/lib.rs", "use toml;")]
            .map(|(path, text)| SourceFile { path: path.into(), text: text.into() });
        let expected: Vec<Finding> = expected.iter().map(|text| Finding(text.to_string())).collect();
        assert_eq!(check(&metadata, &manifest, &files).expect("metadata"), expected);
    }

    #[test]
    fn what_is_declared_has_to_be_used() {
        check_says("x-y = \"1\"", &["x-y"], "use x_y::Z;", &[]);
        check_says("toml = \"1\"", &["toml"], "", &["a depends on toml, which none of its files names"]);
        check_says("x = \"1\"", &[], "x", &["[workspace.dependencies] lists x, which no member depends on"]);
        check_says("x = { package = \"z\", version = \"1\" }", &["z"], "z::f()", &[]);
    }
}
