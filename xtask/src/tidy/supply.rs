//! What is built into the program: licences, banned crates and sources, by `deny.toml`.
//!
//! A part of what cargo-deny does with the same file, without anything to be installed and without a network. What only it
//! does is advisories: `cargo deny check advisories`.

use super::Finding;
use anyhow::{Context, Result};
use std::collections::BTreeSet;

/// The one registry that crates may come from, as cargo metadata has it.
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// Holds every package of the whole tree against the text of `deny.toml`.
pub fn check(metadata: &serde_json::Value, deny: &str) -> Result<Vec<Finding>> {
    let deny: toml::Table = deny.parse().context("deny.toml is not TOML")?;
    let list = |table: &str, key: &str| {
        deny.get(table).and_then(|t| t.get(key)).and_then(toml::Value::as_array).cloned().unwrap_or_default()
    };
    let allowed: BTreeSet<String> =
        list("licenses", "allow").iter().filter_map(|v| v.as_str().map(String::from)).collect();
    let banned: BTreeSet<String> = list("bans", "deny")
        .iter()
        .filter_map(|v| v.get("crate").and_then(toml::Value::as_str).map(String::from))
        .collect();
    let packages = metadata["packages"].as_array().context("cargo metadata lists no packages")?;
    let mut findings = Vec::new();
    for package in packages {
        let name = package["name"].as_str().context("a package without a name")?;
        let Some(source) = package["source"].as_str() else { continue }; // a crate of the workspace
        if source != REGISTRY {
            findings.push(Finding(format!("{name} comes from {source}, not from crates.io")));
        }
        if banned.contains(name) {
            findings.push(Finding(format!("{name} is banned by deny.toml")));
        }
        let licence = package["license"].as_str().unwrap_or_default();
        if !permitted(licence, &allowed) {
            findings.push(Finding(format!("{name}: no licence of `{licence}` is allowed by deny.toml")));
        }
    }
    Ok(findings)
}

/// Whether an SPDX expression can be met: one alternative of `OR` of which every part of `AND` is allowed. Brackets around
/// alternatives bind first.
fn permitted(licence: &str, allowed: &BTreeSet<String>) -> bool {
    let text = licence.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let words: Vec<&str> = text.split_whitespace().collect();
    let mut at = 0;
    !words.is_empty() && any_of(&words, &mut at, allowed) && at == words.len()
}

fn any_of(words: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let mut met = all_of(words, at, allowed);
    while words.get(*at) == Some(&"OR") {
        *at += 1;
        met |= all_of(words, at, allowed);
    }
    met
}

fn all_of(words: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let mut met = one(words, at, allowed);
    while words.get(*at) == Some(&"AND") {
        *at += 1;
        met &= one(words, at, allowed);
    }
    met
}

fn one(words: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let Some(word) = words.get(*at) else { return false };
    *at += 1;
    if *word == "(" {
        let met = any_of(words, at, allowed);
        *at += usize::from(words.get(*at) == Some(&")"));
        return met;
    }
    let mut name = (*word).to_owned();
    if words.get(*at) == Some(&"WITH") {
        name += &format!(" WITH {}", words.get(*at + 1).copied().unwrap_or_default());
        *at += 2;
    }
    allowed.contains(&name)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DENY: &str = "[licenses]\nallow = [\"MIT\", \"Zlib\", \"Apache-2.0 WITH LLVM-exception\"]\n[bans]\ndeny = [{ crate = \"curl\" }]\n";

    #[test]
    fn expressions_are_understood() {
        let allowed = ["MIT", "Zlib", "Apache-2.0 WITH LLVM-exception"].map(String::from).into();
        for good in [
            "MIT",
            "MIT OR GPL-3.0",
            "GPL-3.0/MIT",
            "MIT AND Zlib",
            "(MIT OR GPL-3.0) AND Zlib",
            "Apache-2.0 WITH LLVM-exception OR X",
        ] {
            assert!(permitted(good, &allowed), "{good}");
        }
        for bad in ["", "GPL-3.0", "MIT AND GPL-3.0", "(MIT AND GPL-3.0) OR X", "Apache-2.0", "MIT )"] {
            assert!(!permitted(bad, &allowed), "{bad}");
        }
    }

    #[test]
    fn strangers_are_told() {
        let package = |name: &str, licence: &str, source: &str| serde_json::json!({"name": name, "license": licence, "source": source});
        let metadata = serde_json::json!({"packages": [
            package("good", "MIT OR Apache-2.0", REGISTRY),
            package("curl", "MIT", REGISTRY),
            package("taken", "GPL-3.0", REGISTRY),
            package("elsewhere", "MIT", "git+https://example.org/x"),
            {"name": "ours", "license": null, "source": null},
        ]});
        assert_eq!(check(&metadata, DENY).map(|found| found.len()).unwrap_or(0), 3);
    }
}
