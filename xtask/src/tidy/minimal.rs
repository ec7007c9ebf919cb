//! The least version that is asked of a dependency is the one that the tests run with.
//!
//! A requirement `1.2.3` admits every later 1.x; that 1.2.3 itself is enough is only known where it is the version in `Cargo.lock`. So no
//! build of its own with minimal versions is needed (of direct dependencies: `-Z direct-minimal-versions` of cargo resolves to the same).

use super::Finding;
use anyhow::{Context, Result};

/// Holds the requirements of `[workspace.dependencies]` against the versions in the lock file.
pub fn check(manifest: &str, lock: &str) -> Result<Vec<Finding>> {
    let manifest: toml::Table = manifest.parse().context("Cargo.toml is not TOML")?;
    let lock: toml::Table = lock.parse().context("Cargo.lock is not TOML")?;
    let locked =
        lock.get("package").and_then(toml::Value::as_array).context("Cargo.lock lists no packages")?;
    let shared =
        manifest.get("workspace").and_then(|w| w.get("dependencies")).and_then(toml::Value::as_table);
    let mut findings = Vec::new();
    for (name, value) in shared.context("Cargo.toml has no [workspace.dependencies]")? {
        if value.get("path").is_some() {
            continue;
        }
        let package = value.get("package").and_then(toml::Value::as_str).unwrap_or(name);
        let version = value.get("version").unwrap_or(value).as_str().unwrap_or_default();
        let text =
            |entry: &toml::Value, key: &str| entry.get(key).and_then(toml::Value::as_str).map(String::from);
        let versions: Vec<String> = locked
            .iter()
            .filter(|entry| text(entry, "name").as_deref() == Some(package))
            .filter_map(|entry| Some(text(entry, "version")?.split('+').next()?.to_owned()))
            .collect();
        if !versions.iter().any(|locked| locked == version.trim_start_matches('=')) {
            findings.push(Finding(format!(
                "{name} = \"{version}\" is not what the tests run with: ask for {}",
                versions.join(" or ")
            )));
        }
    }
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_says(shared: &str, expected: &[&str]) {
        let manifest = format!("[workspace.dependencies]\n{shared}");
        let lock = "[[package]]\nname = \"x\"\nversion = \"1.2.3+more\"\n[[package]]\nname = \"x\"\nversion = \"2.0.0\"\n";
        let expected: Vec<Finding> = expected.iter().map(|text| Finding(text.to_string())).collect();
        assert_eq!(check(&manifest, lock).expect("TOML"), expected);
    }

    #[test]
    fn what_is_asked_for_has_to_be_locked() {
        check_says("x = \"1.2.3\"\ny = { path = \"y\", version = \"1\" }", &[]);
        check_says("x = { version = \"=2.0.0\", default-features = false }", &[]);
        check_says("x = \"1.2\"", &["x = \"1.2\" is not what the tests run with: ask for 1.2.3 or 2.0.0"]);
    }
}
