//! Which tests take longer than a change should wait: `cargo xtask slow`, by the times of nextest.
//!
//! One test at a time on a machine that is otherwise idle, so that times are near processor times. Tests that are slow on purpose have the
//! feature `slow` of their crate, and are not in this list.

use anyhow::{Context, Result, bail};
use std::path::Path;
use std::process::Command;

/// Seconds that a test may take.
const MOST: f64 = 5.0;

/// Runs all tests without the feature `slow`; without nextest that is said and is no failure.
pub fn run(root: &Path) -> Result<()> {
    if !Command::new("cargo").args(["nextest", "--version"]).output().is_ok_and(|ran| ran.status.success()) {
        println!("── SKIPPED: cargo-nextest is not installed; times of tests were not measured");
        return Ok(());
    }
    let output = Command::new("cargo")
        .args(["nextest", "run", "--workspace", "--test-threads", "1", "--no-fail-fast", "--color", "never"])
        .args(["--status-level", "all", "--final-status-level", "none"])
        .current_dir(root)
        .output()
        .context("cargo nextest")?;
    let log = String::from_utf8_lossy(&output.stderr);
    let times: Vec<(f64, &str)> = log.lines().filter_map(time).collect();
    if times.is_empty() || !output.status.success() {
        bail!("cargo nextest run failed ({}):\n{log}", output.status);
    }
    let slow: Vec<String> = times
        .iter()
        .filter(|(seconds, _)| *seconds > MOST)
        .map(|(seconds, test)| format!("{test}: {seconds:.1} s"))
        .collect();
    let all: f64 = times.iter().map(|(seconds, _)| seconds).sum();
    println!("{} tests, {all:.0} s, {} above {MOST} s", times.len(), slow.len());
    if !slow.is_empty() {
        bail!(
            "put these behind the feature `slow`, with a fast test of their kind beside them:\n{}",
            slow.join("\n")
        );
    }
    Ok(())
}

/// Seconds and name in a line such as `PASS [   0.012s] (1/9) crate::binary test`.
fn time(line: &str) -> Option<(f64, &str)> {
    let (seconds, rest) = line.trim().strip_prefix("PASS [")?.split_once("s]")?;
    let test = rest.split_once(") ").map_or(rest, |(_, test)| test);
    Some((seconds.trim().parse().ok()?, test.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_from_the_lines_of_nextest() {
        let line = "        PASS [   9.373s] (1284/1284) truepose-third-party::whole_way it_is_discovered";
        assert_eq!(time(line), Some((9.373, "truepose-third-party::whole_way it_is_discovered")));
        assert_eq!(time("     Summary [ 276.290s] 1284 tests run"), None);
    }
}
