//! What CI runs. `.ci/run` is the script that a server starts; this is the same list for a keyboard.

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

const STEPS: [Step; 7] = [
    Step { environment: &[], arguments: &["fmt", "--all", "--check"] },
    Step { environment: &[], arguments: &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"] },
    Step { environment: &[], arguments: &["test", "--workspace"] },
    Step {
        environment: &[],
        arguments: &["test", "-p", "truepose-io", "--features", "parquet", "--test", "parquet"],
    },
    Step {
        environment: &[],
        arguments: &["test", "-p", "truepose-cli", "--features", "parquet", "--test", "program", "parquet"],
    },
    Step { environment: &[("RUSTDOCFLAGS", "-D warnings")], arguments: &["doc", "--workspace", "--no-deps"] },
    Step { environment: &[], arguments: &["xtask", "tidy"] },
];

/// With cargo-deny, where it is installed; the second where the database of advisories can be fetched.
const DENY: [Step; 2] = [
    Step { environment: &[], arguments: &["deny", "--offline", "check", "licenses", "bans", "sources"] },
    Step { environment: &[], arguments: &["deny", "--offline", "check", "advisories"] },
];

/// Runs all steps, stopping at the first that fails.
pub fn run(root: &Path) -> Result<()> {
    for step in &STEPS {
        one(step, root)?;
    }
    if !works(&["deny", "--version"], root) {
        println!("── SKIPPED: cargo deny is not installed");
        return Ok(());
    }
    one(&DENY[0], root)?;
    if !works(&["deny", "fetch", "db"], root) {
        println!("── SKIPPED: the database of advisories cannot be fetched");
        return Ok(());
    }
    one(&DENY[1], root)
}

fn one(step: &Step, root: &Path) -> Result<()> {
    println!("── {}", line(step));
    let begun = Instant::now();
    finished(
        Command::new("cargo").args(step.arguments).envs(step.environment.iter().copied()).current_dir(root),
    )?;
    println!("   {:.0} s", begun.elapsed().as_secs_f64());
    Ok(())
}

/// Whether cargo does this, silently.
fn works(arguments: &[&str], root: &Path) -> bool {
    let ran = Command::new("cargo").args(arguments).current_dir(root).output();
    ran.is_ok_and(|ran| ran.status.success())
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
        let commands: Vec<&str> =
            script.lines().filter_map(|line| line.trim_start().strip_prefix("step ")).collect();
        let ours: Vec<String> = STEPS.iter().chain(&DENY).map(line).collect();
        assert_eq!(commands, ours);
    }
}
