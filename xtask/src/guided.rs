//! Readers under libFuzzer: `cargo xtask guided READER -max_total_time=600`.
//!
//! What `cargo fuzz` does, without it and with the stable toolchain: the package `lab/guided`, a workspace of its own, is compiled with counters at
//! every edge of the program and run on `lab/guided/corpus/READER`. New inputs go to `target/fuzz/guided/READER`, findings to `target/fuzz`.

use crate::finished;
use anyhow::{Context, Result};
use std::path::Path;
use std::process::Command;

/// Counters at every edge, and the operands of comparisons.
const FLAGS: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=16";

/// Builds and runs it; further words are libFuzzer's.
pub fn run(root: &Path, reader: &str, rest: &[String]) -> Result<()> {
    let package = root.join("lab/guided");
    // Named, so that build scripts are compiled without counters.
    let version = Command::new("rustc").arg("-vV").output().context("rustc")?;
    let version = String::from_utf8(version.stdout)?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).context("rustc tells no host")?;
    let target = root.join("target/fuzz/build");
    finished(
        Command::new("cargo")
            .args(["build", "--release", "--target", host, "--target-dir"])
            .arg(&target)
            .env("RUSTFLAGS", FLAGS)
            .current_dir(&package),
    )?;
    let (own, kept) = (root.join("target/fuzz/guided").join(reader), package.join("corpus").join(reader));
    std::fs::create_dir_all(&own)?;
    std::fs::create_dir_all(&kept)?;
    let findings = format!("-artifact_prefix={}/", root.join("target/fuzz").join(reader).display());
    std::fs::create_dir_all(root.join("target/fuzz").join(reader))?;
    finished(
        Command::new(target.join(host).join("release/reader"))
            .args(["-max_len=6000", "-timeout=10", "-rss_limit_mb=2000", "-print_final_stats=1", &findings])
            .args(rest)
            .args([own, kept])
            .env("TRUEPOSE_FUZZ", reader),
    )
}
