//! Dependencies that nobody uses.

use super::{Finding, SourceFile};
use anyhow::{Context, Result};
use std::collections::BTreeSet;

/// Named by nobody and needed: argmin's mathematics for vectors is a feature of this crate, which argmin itself uses.
const NEEDED: [(&str, &str); 1] = [("truepose-solvers", "argmin-math")];

/// Holds `[workspace.dependencies]` against the members, and what each member declares against the names in its files.
pub fn check(
    root: &str,
    metadata: &serde_json::Value,
    manifest: &str,
    files: &[SourceFile],
) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let mut declared: BTreeSet<&str> = BTreeSet::new();
    for package in metadata["packages"].as_array().context("cargo metadata lists no packages")? {
        let name = package["name"].as_str().context("a package without a name")?;
        let manifest = package["manifest_path"].as_str().context("a package without a manifest")?;
        let folder = manifest.strip_prefix(root).and_then(|p| p.strip_suffix("Cargo.toml"));
        let folder = folder.context("a crate outside the repository")?.trim_start_matches('/');
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

/// All identifiers in a crate's sources, in its README, whose examples are tests, and in folders elsewhere of which it includes a module.
fn names<'a>(folder: &str, files: &'a [SourceFile]) -> BTreeSet<&'a str> {
    let own = |file: &&SourceFile| {
        file.path.starts_with(folder) && (file.path.ends_with(".rs") || file.path.ends_with(".md"))
    };
    let included: Vec<&str> = files.iter().filter(own).flat_map(|file| elsewhere(&file.text)).collect();
    files
        .iter()
        .filter(|file| own(file) || included.iter().any(|folder| file.path.starts_with(folder)))
        .flat_map(|file| file.text.split(|c: char| !c.is_alphanumeric() && c != '_'))
        .collect()
}

/// Folders of modules that are included by a path upwards: of `#[path = "../../tests/a/mod.rs"]` it is `tests/a`.
fn elsewhere(text: &str) -> impl Iterator<Item = &str> {
    let paths = text.split("#[path = \"..").skip(1).filter_map(|rest| rest.split_once("/mod.rs\""));
    paths.map(|(path, _)| path.trim_start_matches(['.', '/']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_says(shared: &str, dependencies: &[&str], code: &str, expected: &[&str]) {
        let dependencies: Vec<_> =
            dependencies.iter().map(|name| serde_json::json!({"name": name})).collect();
        let metadata = serde_json::json!({"packages": [
            {"name": "a", "dependencies": dependencies, "manifest_path": "/x/crates/a/Cargo.toml"}]});
        let manifest = format!("[workspace.dependencies]\n{shared}");
        let files = [("crates/a/src/lib.rs", code), ("crates/b/src/lib.rs", "use toml;")]
            .map(|(path, text)| SourceFile { path: path.into(), text: text.into() });
        let expected: Vec<Finding> = expected.iter().map(|text| Finding(text.to_string())).collect();
        assert_eq!(check("/x", &metadata, &manifest, &files).expect("metadata"), expected);
    }

    #[test]
    fn what_is_declared_has_to_be_used() {
        check_says("x-y = \"1\"", &["x-y"], "use x_y::Z;", &[]);
        check_says("toml = \"1\"", &["toml"], "", &["a depends on toml, which none of its files names"]);
        check_says("x = \"1\"", &[], "x", &["[workspace.dependencies] lists x, which no member depends on"]);
        check_says("x = { package = \"z\", version = \"1\" }", &["z"], "z::f()", &[]);
    }

    #[test]
    fn included_modules_count() {
        let text = "#[path = \"../../../tests/a/mod.rs\"]\nmod a;\n#[path = \"../b/mod.rs\"]\nmod b;";
        assert_eq!(elsewhere(text).collect::<Vec<_>>(), ["tests/a", "b"]);
    }
}
