//! The golden corpus: what the program prints and writes on some eighty runs, kept in `tests/golden`. `cargo xtask golden` repeats them.
//!
//! A scenario of `corpus.toml` is a folder with the examples, small files of its own, and commands that are run in it one after the other.
//! Its snapshot holds each command with its exit code and what it printed, and each file that it wrote: the SHA-256 of the bytes, and a digest
//! that a person can read (`digest`). Two levels: *same bytes*, where the snapshots are equal, and *same findings*, where all words are and
//! numbers agree to 1e-9 of their size (`compare`). Other processors and mathematical libraries reach the second level alone.

mod compare;
mod digest;

use crate::finished;
use anyhow::{Context, Result, bail};
use compare::{Level, compare};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

const FOLDER: &str = "tests/golden";

/// What is run, and how the results are used.
#[derive(clap::Args)]
pub struct Options {
    /// Write the snapshots instead of comparing with them; `git diff tests/golden` is what a reviewer reads.
    #[arg(long)]
    write: bool,
    /// The fast scenarios alone: a minute.
    #[arg(long)]
    fast: bool,
    /// Fail where bytes differ, too.
    #[arg(long)]
    bytes: bool,
    /// The program to run instead of building it, e.g. that of another commit.
    #[arg(long)]
    program: Option<PathBuf>,
    /// Scenarios whose name contains this.
    only: Option<String>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Corpus {
    scenarios: Vec<Scenario>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Scenario {
    name: String,
    /// Whether continuous integration runs it.
    #[serde(default)]
    fast: bool,
    /// Run once with each of these in place of `{seed}`.
    #[serde(default)]
    seeds: Vec<u64>,
    /// Text files by name.
    #[serde(default)]
    files: BTreeMap<String, String>,
    /// A file by line; `truepose` in front is left out. A line that begins with `python` is run by the interpreter that has the wheel.
    commands: String,
}

pub fn run(root: &Path, options: &Options) -> Result<()> {
    let text = std::fs::read_to_string(root.join(FOLDER).join("corpus.toml")).context("corpus.toml")?;
    let corpus: Corpus = toml::from_str(&text).context("corpus.toml")?;
    let program = match &options.program {
        Some(program) => program.canonicalize().with_context(|| program.display().to_string())?,
        None => built(root, options.fast)?,
    };
    let target = target(root);
    let begun = Instant::now();
    let (mut runs, mut same, mut close, mut other) = (0, 0, 0, Vec::new());
    for (name, scenario, seed) in listed(&corpus) {
        let wanted = options.only.as_ref().is_none_or(|part| name.contains(part.as_str()));
        if !wanted || (options.fast && !scenario.fast) {
            continue;
        }
        let folder = target.join("golden").join(&name);
        let Some((snapshot, count)) = played(root, &folder, &program, scenario, seed)? else {
            println!(
                "── SKIPPED: {name}: no Python with the wheel in target/python/fresh (made by .ci/python)"
            );
            continue;
        };
        runs += count;
        let path = root.join(FOLDER).join(format!("{name}.txt"));
        if options.write {
            std::fs::write(&path, snapshot)?;
            continue;
        }
        let before = std::fs::read_to_string(&path).unwrap_or_default();
        match compare(&before, &snapshot) {
            Level::SameBytes => same += 1,
            Level::SameFindings => close += 1,
            Level::Different(difference) => {
                println!("{name}: {difference}");
                std::fs::write(folder.join("snapshot.txt"), snapshot)?;
                println!("  diff {FOLDER}/{name}.txt {}", folder.join("snapshot.txt").display());
                other.push(name);
            }
        }
    }
    let seconds = begun.elapsed().as_secs_f64();
    if options.write {
        println!("{runs} runs written to {FOLDER}, {seconds:.0} s");
        return Ok(());
    }
    println!(
        "{runs} runs, {seconds:.0} s: scenarios with the same bytes {same}, the same findings {close}, others {}",
        other.len()
    );
    if !other.is_empty() || (options.bytes && close > 0) {
        bail!("golden: {}; where that is meant: cargo xtask golden --write", other.join(", "));
    }
    Ok(())
}

/// Each scenario with each of its seeds, by name.
fn listed(corpus: &Corpus) -> impl Iterator<Item = (String, &Scenario, u64)> {
    corpus.scenarios.iter().flat_map(|scenario| {
        let one = scenario.seeds.is_empty().then_some((scenario.name.clone(), scenario, 0));
        let each =
            scenario.seeds.iter().map(move |seed| (format!("{}-{seed}", scenario.name), scenario, *seed));
        one.into_iter().chain(each)
    })
}

fn target(root: &Path) -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from)
}

/// The program: that of the tests where it is to be fast to come by, else the release.
fn built(root: &Path, fast: bool) -> Result<PathBuf> {
    // As `cargo test --workspace` builds it: of other packages features differ, and with them what is compiled.
    let arguments: &[&str] = if fast {
        &["test", "--quiet", "--workspace", "--no-run"]
    } else {
        &["build", "--quiet", "--release", "--package", "truepose-cli", "--all-features"]
    };
    finished(Command::new("cargo").args(arguments).current_dir(root))?;
    Ok(target(root).join(if fast { "debug/truepose" } else { "release/truepose" }))
}

/// The snapshot of a scenario, and the number of its commands; none where a Python is missing.
fn played(
    root: &Path,
    folder: &Path,
    program: &Path,
    scenario: &Scenario,
    seed: u64,
) -> Result<Option<(String, usize)>> {
    let python = target(root).join("python/fresh/bin/python");
    if scenario.commands.lines().any(|line| line.starts_with("python ")) && !python.exists() {
        return Ok(None);
    }
    if folder.exists() {
        std::fs::remove_dir_all(folder)?;
    }
    std::fs::create_dir_all(folder.join("examples"))?;
    for example in
        ["01_identify", "02_measured_robot", "03_unexplained", "09_sockets", "10_hand_eye", "11_two_arms"]
    {
        let (from, to) = (root.join("examples").join(example), folder.join("examples").join(example));
        std::fs::create_dir_all(&to)?;
        for file in std::fs::read_dir(from)? {
            let file = file?;
            std::fs::copy(file.path(), to.join(file.file_name()))?;
        }
    }
    for (name, text) in &scenario.files {
        std::fs::write(folder.join(name), text)?;
    }
    let mut known = files(folder)?;
    let (mut snapshot, mut count) = (String::new(), 0);
    for line in scenario.commands.lines().map(|line| line.trim().replace("{seed}", &seed.to_string())) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let (runs, arguments) = match words[..] {
            [] => continue,
            ["python", ref rest @ ..] => (python.as_path(), rest),
            ref all => (program, all),
        };
        let output = Command::new(runs)
            .args(arguments)
            .env("RAYON_NUM_THREADS", "2")
            .current_dir(folder)
            .output()
            .with_context(|| line.clone())?;
        count += 1;
        let code = output.status.code().map_or("ended by a signal".into(), |code| format!("exit {code}"));
        writeln!(snapshot, "$ {line}\n[{code}]")?;
        for (stream, bytes) in [("", &output.stdout), ("! ", &output.stderr)] {
            for line in digest::printed(&String::from_utf8_lossy(bytes)).lines() {
                writeln!(snapshot, "{stream}{line}")?;
            }
        }
        let now = files(folder)?;
        for (name, hash) in &now {
            if known.get(name) != Some(hash) {
                let bytes = std::fs::read(folder.join(name))?;
                writeln!(
                    snapshot,
                    "--- {name}\nsha256 {hash}\n{}",
                    digest::readable(name, &bytes).trim_end()
                )?;
            }
        }
        known = now;
        snapshot.push('\n');
    }
    Ok(Some((snapshot, count)))
}

/// All files below a folder but the examples, with their hashes, by name.
fn files(folder: &Path) -> Result<BTreeMap<String, String>> {
    let mut found = BTreeMap::new();
    let mut open = vec![PathBuf::new()];
    while let Some(inner) = open.pop() {
        for entry in std::fs::read_dir(folder.join(&inner))? {
            let entry = entry?;
            let name = inner.join(entry.file_name());
            if entry.file_type()?.is_dir() {
                if name != Path::new("examples") {
                    open.push(name);
                }
            } else {
                let hash = digest::sha256(&std::fs::read(entry.path())?);
                found.insert(name.to_string_lossy().replace('\\', "/"), hash);
            }
        }
    }
    Ok(found)
}
