//! Chores of the workspace: `cargo xtask VERB`.
//!
//! This crate runs cargo and reads files; it depends on no other crate of the workspace, so that it
//! works while they do not build.

mod ci;
mod coverage;
mod golden;
mod guided;
mod header;
mod instructions;
mod lab;
mod slow;
mod tidy;

use anyhow::{Context, Result, bail};
use clap::{Parser, Subcommand};
use std::path::PathBuf;
use std::process::{Command, ExitCode};

#[derive(Parser)]
#[command(name = "cargo xtask", about = "Chores of the workspace")]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Everything that CI runs, in the same order.
    Ci {
        /// Run instead what is too slow for every change: the whole golden corpus, counts of instructions, the tests of `lab`.
        #[arg(long)]
        slow: bool,
    },
    /// `cargo VERB` on the workspace `lab`, e.g. `test` or `clippy --all-targets`.
    Lab {
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, required = true)]
        words: Vec<String>,
    },
    /// Layers, file lengths, names, licences, READMEs: what neither rustc nor clippy looks at.
    Tidy,
    /// The C header against what cbindgen makes of crates/ffi.
    Header {
        /// Write it instead.
        #[arg(long)]
        write: bool,
    },
    /// Instructions of the program's main jobs against xtask/instructions.toml, where Valgrind is installed.
    Instructions {
        /// Write the file instead.
        #[arg(long)]
        write: bool,
    },
    /// Tests that take more than five seconds though they are not behind the feature `slow`.
    Slow,
    /// Eighty runs of the program against their snapshots in tests/golden.
    Golden(golden::Options),
    /// A benchmark study, in release; leaves its table and figures in target/studies.
    Study {
        /// Which: closed-loop, discovery, guard-band, harm, kinds, orders, pps, reliability, sensitivity, sessions, solvers.
        name: String,
        /// Passed on to the study, e.g. `--short`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        rest: Vec<String>,
    },
    /// Throw spoiled input at everything that reads files; what it finds is kept in target/fuzz.
    Fuzz {
        /// Which: robot, urdf, measurements, model, fit, poses, solver, parquet, or all.
        #[arg(default_value = "all")]
        target: String,
        /// Passed on, e.g. `--inputs 1000000 --seed 7`, or `--for 1h` for each.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        rest: Vec<String>,
    },
    /// The part of the libraries' lines that the tests run.
    Coverage {
        /// Packages whose tests are run; all where none is named.
        packages: Vec<String>,
    },
    /// Relations between files of the same robot (units, names, orders …) on a folder of cases, in release; prints where findings change.
    Metamorphic {
        /// Passed on: `--cases DIR`, `--only CASE`, `--relation WORDS`, `--part 1/2`, `--show`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        rest: Vec<String>,
    },
    /// A reader under a fuzzer that is guided by coverage.
    Guided {
        /// Which: robot, urdf, model, details, fit, history, measurements, poses, program.
        reader: String,
        /// Passed on to libFuzzer, e.g. `-max_total_time=600` or `-runs=10000000`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        rest: Vec<String>,
    },
    /// Micro-benchmarks of kernels, in release.
    Micro {
        /// Which: commands, errormodel, ffi, identify, kinematics, solvers.
        kernels: String,
        /// Passed on to divan: a filter, `--sample-count 20`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        rest: Vec<String>,
    },
    /// Workloads against the peers, in release; leaves its numbers in target/bench.
    Bench {
        /// Passed on: workloads, `--rounds 15`, `--against old.json`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        rest: Vec<String>,
    },
}

fn main() -> ExitCode {
    if let Some(code) = coverage::compiler() {
        return code;
    }
    match run(Arguments::parse().verb) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(verb: Verb) -> Result<()> {
    let root = root()?;
    match verb {
        Verb::Ci { slow } => ci::run(&root, slow),
        Verb::Lab { words } => lab::cargo_verb(&root, &words),
        Verb::Tidy => tidy::run(&root),
        Verb::Header { write } => header::run(&root, write),
        Verb::Slow => slow::run(&root),
        Verb::Golden(options) => golden::run(&root, &options),
        Verb::Instructions { write } => instructions::run(&root, write),
        Verb::Study { name, rest } => lab::program(&root, "studies", "study", &[&[name], &rest[..]].concat()),
        Verb::Fuzz { target, rest } => lab::program(&root, "fuzz", "fuzz", &[&[target], &rest[..]].concat()),
        Verb::Guided { reader, rest } => guided::run(&root, &reader, &rest),
        Verb::Coverage { packages } => coverage::run(&root, &packages),
        Verb::Metamorphic { rest } => lab::program(&root, "metamorphic", "metamorphic", &rest),
        Verb::Bench { rest } => lab::program(&root, "bench", "bench", &rest),
        Verb::Micro { kernels, rest } => lab::kernels(&root, &kernels, &rest),
    }
}

/// The workspace's folder: the one above this crate's.
fn root() -> Result<PathBuf> {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let root = here.parent().context("xtask has no folder above it")?;
    Ok(root.to_path_buf())
}

/// Runs a command to its end; its failure is ours.
fn finished(command: &mut Command) -> Result<()> {
    let shown = format!("{command:?}").replace('"', "");
    let status = command.status().with_context(|| format!("cannot start {shown}"))?;
    if !status.success() {
        bail!("{shown} failed ({status})");
    }
    Ok(())
}
