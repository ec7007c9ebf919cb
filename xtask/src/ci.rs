//! What CI runs. `.ci/run` is the script that a server starts; this is the same list for a keyboard, and a second, slow one.

use crate::finished;
use anyhow::Result;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// One step: environment, then cargo's arguments.
struct Step {
    environment: &'static [(&'static str, &'static str)],
    arguments: &'static [&'static str],
}

const fn step(arguments: &'static [&'static str]) -> Step {
    Step { environment: &[], arguments }
}

/// What fails soonest comes first.
const STEPS: [Step; 6] = [
    step(&["fmt", "--all", "--check"]),
    step(&["xtask", "tidy"]),
    step(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]),
    step(&["test", "--workspace"]),
    step(&["xtask", "golden", "--fast"]),
    Step { environment: &[("RUSTDOCFLAGS", "-D warnings")], arguments: &["doc", "--workspace", "--no-deps"] },
];

/// Behind the documents and the Python package.
const HEADER: Step = step(&["xtask", "header"]);

/// What takes longer than a change should wait: `cargo xtask ci --slow`.
const SLOW: [Step; 8] = [
    step(&["xtask", "slow"]),
    step(&["test", "--workspace", "--features", "truepose-cli/slow,truepose-tests/slow"]),
    step(&["xtask", "golden"]),
    step(&["xtask", "instructions"]),
    // Without the features that can be left out: what these two are made of is checked with them.
    step(&["check", "--no-default-features", "-p", "truepose-discover", "-p", "truepose-io"]),
    step(&["fmt", "--all", "--check", "--manifest-path", "lab/Cargo.toml"]),
    step(&["xtask", "lab", "clippy", "--all-targets", "--", "-D", "warnings"]),
    step(&["xtask", "lab", "test", "--workspace"]),
];

/// With cargo-deny: built where it is not installed, then the sources of all platforms' dependencies, which it looks at; advisories
/// where their database can be fetched.
const DENY: [Step; 4] = [
    Step {
        environment: &[("CARGO_PROFILE_DEV_DEBUG", "0")],
        arguments: &[
            "install",
            "--locked",
            "--debug",
            "--root",
            "target/tools",
            "--target-dir",
            "target/tools/build",
            "cargo-deny@0.20.2",
        ],
    },
    Step { environment: &[], arguments: &["fetch", "--locked"] },
    Step { environment: &[], arguments: &["deny", "--offline", "check", "licenses", "bans", "sources"] },
    Step { environment: &[], arguments: &["deny", "--offline", "check", "advisories"] },
];

/// Runs all steps, stopping at the first that fails.
pub fn run(root: &Path, slow: bool) -> Result<()> {
    if slow {
        return SLOW.iter().try_for_each(|step| one(step, root));
    }
    for step in &STEPS {
        one(step, root)?;
    }
    for script in [".ci/python", ".ci/docs"] {
        println!("── {script}");
        finished(Command::new(root.join(script)).current_dir(root))?;
    }
    one(&HEADER, root)?;
    let [install, fetch, check, advisories] = &DENY;
    if !works(&["deny", "--version"], root) {
        if one(install, root).is_err() {
            return skipped("cargo-deny is not installed, and could not be (above)");
        }
        std::fs::remove_dir_all(root.join("target/tools/build"))?;
    }
    if one(fetch, root).is_err() {
        return skipped(
            "cargo-deny needs the sources of all dependencies, which could not be fetched (above)",
        );
    }
    one(check, root)?;
    if !works(&["deny", "fetch", "db"], root) {
        return skipped("the database of advisories cannot be fetched");
    }
    one(advisories, root)
}

/// What is out of reach is said, and is no failure.
fn skipped(why: &str) -> Result<()> {
    println!("── SKIPPED: {why}");
    Ok(())
}

fn one(step: &Step, root: &Path) -> Result<()> {
    println!("── {}", line(step));
    let begun = Instant::now();
    finished(cargo(step.arguments, root).envs(step.environment.iter().copied()))?;
    println!("   {:.0} s", begun.elapsed().as_secs_f64());
    Ok(())
}

/// Cargo at the root, which also finds the tools that were built there.
fn cargo(arguments: &[&str], root: &Path) -> Command {
    let mut command = Command::new("cargo");
    let others = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::iter::once(root.join("target/tools/bin")).chain(std::env::split_paths(&others));
    if let Ok(path) = std::env::join_paths(folders) {
        command.env("PATH", path);
    }
    command.args(arguments).current_dir(root);
    command
}

/// Whether cargo does this, silently.
fn works(arguments: &[&str], root: &Path) -> bool {
    cargo(arguments, root).output().is_ok_and(|ran| ran.status.success())
}

/// The step as one would type it.
fn line(step: &Step) -> String {
    let environment = step.environment.iter().map(|(name, value)| format!("{name}=\"{value}\" "));
    format!("{}cargo {}", environment.collect::<String>(), step.arguments.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_runs_the_same_steps_in_the_same_order() {
        let script = include_str!("../../.ci/run");
        let step = |line: &'static str| {
            let line = line.trim_start();
            Some(line.strip_prefix("if ! ").unwrap_or(line).strip_prefix("step ")?.trim_end_matches("; then"))
        };
        let commands: Vec<&str> = script.lines().filter_map(step).collect();
        let ours: Vec<String> = STEPS.iter().chain([&HEADER]).chain(&DENY).map(line).collect();
        assert_eq!(commands, ours);
    }

    /// The name and the text of each manifest of the workspace's crates and tests.
    fn manifests() -> Vec<(String, String)> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let crates = std::fs::read_dir(root.join("crates")).unwrap().map(|entry| entry.unwrap().path());
        let read = |folder: std::path::PathBuf| {
            let text = std::fs::read_to_string(folder.join("Cargo.toml")).unwrap();
            let name =
                text.lines().find_map(|line| line.strip_prefix("name = \"")?.strip_suffix('"')).unwrap();
            (name.to_owned(), text)
        };
        crates.chain([root.join("tests")]).map(read).collect()
    }

    #[test]
    fn the_slow_list_has_every_feature_slow_and_names_that_exist() {
        let manifests = manifests();
        let mut slow: Vec<String> = manifests
            .iter()
            .filter(|(_, text)| text.lines().any(|line| line == "slow = []"))
            .map(|(name, _)| format!("{name}/slow"))
            .collect();
        slow.sort();
        let words = || SLOW.iter().flat_map(|step| step.arguments.windows(2));
        let after =
            |option: &str| words().filter(|pair| pair[0] == option).map(|pair| pair[1]).collect::<Vec<_>>();
        let mut features: Vec<&str> = after("--features").iter().flat_map(|list| list.split(',')).collect();
        features.sort_unstable();
        assert_eq!(features, slow);
        for package in after("-p") {
            assert!(manifests.iter().any(|(name, _)| name == package), "{package}");
        }
    }

    #[test]
    fn verbs_of_all_steps_are_read() {
        use clap::Parser;
        for step in STEPS.iter().chain([&HEADER]).chain(&SLOW) {
            if step.arguments[0] == "xtask" {
                let read = crate::Arguments::try_parse_from(step.arguments);
                assert!(read.is_ok(), "{}", line(step));
            }
        }
    }
}
