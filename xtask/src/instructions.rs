//! How many instructions the program's main jobs take: `cargo xtask instructions`.
//!
//! Wall times on a shared machine are not stable; numbers of instructions are. Each job runs on one thread, on files that ship with the
//! project, under Valgrind's cachegrind without its model of a cache. A job that takes over 3 % more than its number in
//! `xtask/instructions.toml` is a failure. One that takes over 3 % less asks for new numbers (`--write`), or else the gain could be lost
//! unseen. The program is that of the tests' profile, which CI has built already; numbers are those of one version of rustc.

use crate::finished;
use anyhow::{Context, Result, bail};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

const FILE: &str = "xtask/instructions.toml";
/// Share by which a number may differ from the one in the file.
const TOLERANCE: f64 = 0.03;
const HEAD: &str = "# Instructions of the program's main jobs, in millions: made by `cargo xtask instructions --write`, held by `cargo xtask instructions`.";

/// Rows of a job that would take minutes with all: twenty configurations.
const FEW: usize = 120;

/// A job: its name, and the program's arguments from the root of the repository.
struct Job {
    name: &'static str,
    arguments: &'static str,
}

const JOBS: [Job; 3] = [
    Job {
        name: "identify",
        arguments: "identify --robot examples/01_identify/robot.toml --data examples/01_identify/measurements.csv --model examples/01_identify/model.toml --out fit.json",
    },
    Job {
        name: "identify_stream",
        arguments: "identify --stream --linear --folds 0 --prior none --robot examples/01_identify/robot.toml --data examples/01_identify/measurements.csv --out fit.json",
    },
    // The declared model, one screen with its rotations, the verdict, on a third of the rows: the whole loop takes minutes under Valgrind.
    Job {
        name: "discover_screen",
        arguments: "discover --most 0 --rotations 199 --robot examples/01_identify/robot.toml --data few.csv --model examples/01_identify/model.toml --out fit.json",
    },
];

/// Counts, and compares with the file or writes it. Without Valgrind, or with another rustc than the file's, that is said and is no failure.
pub fn run(root: &Path, write: bool) -> Result<()> {
    if Command::new("valgrind").arg("--version").output().is_err() {
        println!("── SKIPPED: valgrind is not installed; instructions were not counted");
        return Ok(());
    }
    let rustc = rustc()?;
    let path = root.join(FILE);
    let known = if write { Known::default() } else { Known::read(&path)? };
    if !write && known.rustc != rustc {
        println!("── SKIPPED: {FILE} is of {}, this is {rustc}; instructions were not counted", known.rustc);
        return Ok(());
    }
    // As `cargo test --workspace` builds it: of other packages features differ, and with them what all dependencies are compiled to.
    finished(Command::new("cargo").args(["test", "--quiet", "--workspace", "--no-run"]).current_dir(root))?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let folder = target.join("instructions");
    std::fs::create_dir_all(&folder)?;
    let all = std::fs::read_to_string(root.join("examples/01_identify/measurements.csv"))?;
    let few: String = all.split_inclusive('\n').take(1 + FEW).collect();
    std::fs::write(folder.join("few.csv"), few)?;
    let mut counted = Vec::new();
    for job in &JOBS {
        let millions = count(root, (&target, &folder), job)?;
        let before = known.millions.get(job.name).copied();
        println!("{}", told(job.name, millions, before));
        counted.push((job.name, millions, before));
    }
    if write {
        let lines = counted.iter().map(|(name, millions, _)| format!("{name} = {millions:.1}\n"));
        let text = format!("{HEAD}\nrustc = \"{rustc}\"\n\n[millions]\n{}", lines.collect::<String>());
        return std::fs::write(&path, text).context(FILE);
    }
    let wrong: Vec<&str> = counted
        .iter()
        .filter(|(_, millions, before)| {
            before.is_none_or(|before| (millions / before - 1.0).abs() > TOLERANCE)
        })
        .map(|(name, ..)| *name)
        .collect();
    if !wrong.is_empty() {
        bail!(
            "{}: not within 3 % of {FILE}; where that is meant: cargo xtask instructions --write",
            wrong.join(", ")
        );
    }
    Ok(())
}

/// What the file says.
#[derive(Default)]
struct Known {
    rustc: String,
    millions: BTreeMap<String, f64>,
}

impl Known {
    fn read(path: &Path) -> Result<Known> {
        let text = std::fs::read_to_string(path).context(FILE)?;
        let table: toml::Table = text.parse().context(FILE)?;
        let rustc =
            table.get("rustc").and_then(toml::Value::as_str).with_context(|| format!("{FILE}: rustc"))?;
        let millions = table.get("millions").and_then(toml::Value::as_table);
        let millions = millions.with_context(|| format!("{FILE}: [millions]"))?;
        let number = |(name, value): (&String, &toml::Value)| Some((name.clone(), value.as_float()?));
        Ok(Known { rustc: rustc.into(), millions: millions.iter().filter_map(number).collect() })
    }
}

fn told(name: &str, millions: f64, before: Option<f64>) -> String {
    let change =
        before.map_or(String::new(), |before| format!("{:+7.2} %", 100.0 * (millions / before - 1.0)));
    format!("{name:18} {millions:9.1} million instructions {change}")
}

/// Version and host.
fn rustc() -> Result<String> {
    let output = Command::new("rustc").arg("-vV").output().context("rustc")?;
    let text = String::from_utf8(output.stdout)?;
    let of = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)).unwrap_or_default();
    Ok(format!("{} {}", of("release: "), of("host: ")))
}

/// Millions of instructions of a job.
fn count(root: &Path, (target, folder): (&Path, &Path), job: &Job) -> Result<f64> {
    let output = Command::new("valgrind")
        .args(["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"])
        .arg(target.join("debug/truepose"))
        .args(job.arguments.split(' ').map(|word| match word {
            "fit.json" | "few.csv" => folder.join(word).into_os_string(),
            word => word.into(),
        }))
        .args(["--threads", "1"])
        .current_dir(root)
        .output()
        .context("valgrind")?;
    let told = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        bail!("{}: {told}", job.name);
    }
    refs(&told).with_context(|| format!("{}: valgrind tells no number of instructions: {told}", job.name))
}

/// The number in cachegrind's line `==12== I refs: 1,234,567`, in millions.
fn refs(told: &str) -> Option<f64> {
    let number = told
        .lines()
        .find_map(|line| line.split_once("refs:").filter(|(before, _)| before.trim_end().ends_with('I')))?
        .1;
    Some(number.trim().replace(',', "").parse::<f64>().ok()? / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_is_read_out_of_cachegrind_s_words() {
        assert_eq!(refs("==7== \n==7== I   refs:      1,234,500,000\n"), Some(1234.5));
        assert_eq!(refs("==7== D refs: 12"), None);
    }
}
