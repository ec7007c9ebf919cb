//! Who may depend on whom: `[workspace.metadata.layers]` against what the crates declare.
//!
//! Normal, build and dev dependencies count alike: a test of a lower crate that needs an upper one belongs
//! in the upper one, or in `tests`.

use super::Finding;
use anyhow::{Context, Result};
use std::collections::{BTreeMap, BTreeSet};

/// The table: for each crate the crates that it may depend on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table(BTreeMap<String, BTreeSet<String>>);

/// A crate of the workspace and what it says about its dependencies: name and kind of each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// Name and kind (`normal`, `build`, `dev`) of each dependency, strangers included.
    pub dependencies: Vec<(String, String)>,
}

impl Table {
    /// Reads the table from the text of the workspace's manifest.
    pub fn from_manifest(text: &str) -> Result<Table> {
        let manifest: toml::Table = text.parse().context("Cargo.toml is not TOML")?;
        let table = manifest
            .get("workspace")
            .and_then(|v| v.get("metadata"))
            .and_then(|v| v.get("layers"))
            .and_then(toml::Value::as_table)
            .context("Cargo.toml has no [workspace.metadata.layers]")?;
        let mut layers = BTreeMap::new();
        for (name, allowed) in table {
            let list = allowed.as_array().with_context(|| format!("layers: {name} is not a list"))?;
            let names: Option<BTreeSet<String>> = list.iter().map(|v| v.as_str().map(String::from)).collect();
            layers.insert(
                name.clone(),
                names.with_context(|| format!("layers: {name} lists what is not a name"))?,
            );
        }
        Ok(Table(layers))
    }

    /// How many crates it lists.
    pub fn len(&self) -> usize {
        self.0.len()
    }
}

/// The crates in the output of `cargo metadata --no-deps`.
pub fn packages(metadata: &serde_json::Value) -> Result<Vec<Package>> {
    let listed = metadata["packages"].as_array().context("cargo metadata lists no packages")?;
    listed
        .iter()
        .map(|package| {
            let name = package["name"].as_str().context("a package without a name")?.to_owned();
            let dependencies =
                package["dependencies"].as_array().context("a package without dependencies")?;
            let dependencies = dependencies
                .iter()
                .map(|d| {
                    let on = d["name"].as_str().context("a dependency without a name")?;
                    Ok((on.to_owned(), d["kind"].as_str().unwrap_or("normal").to_owned()))
                })
                .collect::<Result<Vec<_>>>()?;
            Ok(Package { name, dependencies })
        })
        .collect()
}

/// Holds the table against the crates.
pub fn check(Table(table): &Table, packages: &[Package]) -> Vec<Finding> {
    let members: BTreeSet<&str> = packages.iter().map(|p| p.name.as_str()).collect();
    let mut findings = Vec::new();
    for package in packages {
        let Some(allowed) = table.get(&package.name) else {
            findings.push(Finding(format!(
                "{} stands in no layer; list it in [workspace.metadata.layers]",
                package.name
            )));
            continue;
        };
        for (on, kind) in &package.dependencies {
            let ours = members.contains(on.as_str()) || on.starts_with("truepose-");
            if ours && !allowed.contains(on) {
                findings.push(Finding(format!(
                    "{} has a {kind} dependency on {on}, which its layer does not allow",
                    package.name
                )));
            }
        }
    }
    for (name, allowed) in table {
        for listed in std::iter::once(name).chain(allowed) {
            if !members.contains(listed.as_str()) {
                findings.push(Finding(format!("the layers name {listed}, which is no crate here")));
            }
        }
    }
    if let Some(name) = on_a_cycle(table) {
        findings.push(Finding(format!("the layers go round in a circle through {name}")));
    }
    findings
}

/// A crate that may, through others, depend on itself. Crates whose dependencies are all settled are taken
/// away until nothing changes; what is left hangs on a circle.
fn on_a_cycle(table: &BTreeMap<String, BTreeSet<String>>) -> Option<String> {
    let mut left: BTreeSet<&String> = table.keys().collect();
    loop {
        let settled: Vec<&String> =
            left.iter().copied().filter(|name| table[*name].iter().all(|on| !left.contains(on))).collect();
        if settled.is_empty() {
            return left.first().map(|name| (*name).clone());
        }
        for name in settled {
            left.remove(name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(name: &str, dependencies: &[(&str, &str)]) -> Package {
        Package {
            name: name.into(),
            dependencies: dependencies.iter().map(|(on, kind)| (on.to_string(), kind.to_string())).collect(),
        }
    }

    #[track_caller]
    fn check_says(layers: &str, packages: &[Package], expected: &[&str]) {
        let manifest = format!("[workspace.metadata.layers]\n{layers}");
        let table = Table::from_manifest(&manifest).expect("a table");
        let said: Vec<String> = check(&table, packages).into_iter().map(|Finding(text)| text).collect();
        assert_eq!(said, expected);
    }

    #[test]
    fn what_the_table_allows_passes() {
        check_says(
            "low = []\nhigh = [\"low\"]",
            &[package("low", &[("serde", "normal")]), package("high", &[("low", "normal"), ("low", "dev")])],
            &[],
        );
    }

    #[test]
    fn a_dependency_upwards_fails_whatever_its_kind() {
        for kind in ["normal", "build", "dev"] {
            check_says(
                "low = []\nhigh = [\"low\"]",
                &[package("low", &[("high", kind)]), package("high", &[])],
                &[&format!("low has a {kind} dependency on high, which its layer does not allow")],
            );
        }
    }

    #[test]
    fn a_crate_without_a_layer_and_a_layer_without_a_crate_fail() {
        check_says(
            "gone = []",
            &[package("new", &[])],
            &[
                "new stands in no layer; list it in [workspace.metadata.layers]",
                "the layers name gone, which is no crate here",
            ],
        );
    }

    #[test]
    fn a_circle_in_the_table_fails() {
        check_says(
            "a = [\"b\"]\nb = [\"c\"]\nc = [\"a\"]\nd = []",
            &[package("a", &[]), package("b", &[]), package("c", &[]), package("d", &[])],
            &["the layers go round in a circle through a"],
        );
    }

    #[test]
    fn kinds_are_read_from_the_metadata() {
        let metadata = serde_json::json!({"packages": [{"name": "a", "dependencies": [
            {"name": "b", "kind": null}, {"name": "c", "kind": "dev"}]}]});
        assert_eq!(packages(&metadata).expect("packages"), [package("a", &[("b", "normal"), ("c", "dev")])]);
    }
}
