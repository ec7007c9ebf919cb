//! Programs of `lab`, a workspace of its own: built in release into `target/lab`, run in the root of the repository.

use crate::finished;
use anyhow::Result;
use std::path::Path;
use std::process::Command;

/// `cargo VERB` on the workspace `lab`.
fn cargo(root: &Path, verb: &str) -> Command {
    let mut command = Command::new("cargo");
    command.args([verb, "--manifest-path", "lab/Cargo.toml", "--target-dir", "target/lab"]).current_dir(root);
    command
}

/// A verb of cargo with its arguments.
pub fn cargo_verb(root: &Path, words: &[String]) -> Result<()> {
    let [verb, rest @ ..] = words else { anyhow::bail!("which verb of cargo?") };
    finished(cargo(root, verb).args(rest))
}

/// Builds a program and runs it with these arguments.
pub fn program(root: &Path, package: &str, name: &str, arguments: &[String]) -> Result<()> {
    let package = format!("truepose-{package}");
    let mut command = cargo(root, "run");
    command.args(["--release", "--package", &package, "--bin", name, "--"]).args(arguments);
    finished(&mut command)
}

/// Builds micro-benchmarks and runs them.
pub fn kernels(root: &Path, name: &str, arguments: &[String]) -> Result<()> {
    let mut command = cargo(root, "bench");
    command.args(["--package", "truepose-micro", "--bench", name, "--"]).args(arguments);
    finished(&mut command)
}
