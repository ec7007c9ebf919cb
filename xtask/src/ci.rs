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

const STEPS: [Step; 6] = [
    Step { environment: &[], arguments: &["fmt", "--all", "--check"] },
    Step { environment: &[], arguments: &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"] },
    Step { environment: &[], arguments: &["test", "--workspace"] },
    Step {
        environment: &[],
        arguments: &["test", "-p", "truepose-io", "--features", "parquet", "--test", "parquet"],
    },
    Step { environment: &[("RUSTDOCFLAGS", "-D warnings")], arguments: &["doc", "--workspace", "--no-deps"] },
    Step { environment: &[], arguments: &["xtask", "tidy"] },
];

/// Runs all steps, stopping at the first that fails.
pub fn run(root: &Path) -> Result<()> {
    for step in &STEPS {
        println!("── {}", line(step));
        let begun = Instant::now();
        finished(
            Command::new("cargo")
                .args(step.arguments)
                .envs(step.environment.iter().copied())
                .current_dir(root),
        )?;
        println!("   {:.0} s", begun.elapsed().as_secs_f64());
    }
    Ok(())
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
        let commands: Vec<&str> = script.lines().filter_map(|line| line.strip_prefix("step ")).collect();
        let ours: Vec<String> = STEPS.iter().map(line).collect();
        assert_eq!(commands, ours);
    }
}
