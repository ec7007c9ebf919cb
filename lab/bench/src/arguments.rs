//! The command line and the environment.

use clap::Parser;
use std::path::PathBuf;

/// Options of a run, and where things are.
#[derive(Debug, Clone, Parser)]
pub struct Arguments {
    /// Workloads to run; all when empty. `W3` stands for all that begin so; `growth`, `discover` or `breadth` alone is no workload but how time grows.
    pub only: Vec<String>,
    /// How often both sides are run in turn.
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..))]
    pub rounds: u32,
    /// Results of an earlier run, to compare with.
    #[arg(long)]
    pub against: Option<PathBuf>,
    /// Where the results go.
    #[arg(long, default_value_os_t = target().join("bench/results.json"))]
    pub out: PathBuf,
    /// Where the figure of growth goes.
    #[arg(long, default_value = "docs/figures/growth.svg")]
    pub figure: PathBuf,
    /// Rows up to which `discover` is run.
    #[arg(long, default_value_t = 1_000_000)]
    pub most_rows: usize,
    /// Joints up to which `breadth` is run.
    #[arg(long, default_value_t = 30)]
    pub most_joints: usize,
    /// One way of one workload, for a parent process: `W1 gram`.
    #[arg(long, num_args = 2)]
    pub serve: Vec<String>,
    /// Threads of our side.
    #[arg(long, default_value_t = 1)]
    pub threads: usize,
    /// The folder of the peers' scripts.
    #[arg(skip = from("TRUEPOSE_PEERS", "../shared/peers".into()))]
    pub peers: PathBuf,
    /// Python with the peers' packages.
    #[arg(skip = from("TRUEPOSE_PEERS_PYTHON", target().join("peers-venv/bin/python")))]
    pub python: PathBuf,
    /// The folder of the peers' data.
    #[arg(skip = from("TRUEPOSE_PEERS_DATA", target().join("bench/data")))]
    pub data: PathBuf,
}

fn target() -> PathBuf {
    from("CARGO_TARGET_DIR", "target".into())
}

fn from(name: &str, otherwise: PathBuf) -> PathBuf {
    std::env::var_os(name).map_or(otherwise, PathBuf::from)
}

impl Arguments {
    /// Whether a workload was asked for.
    pub fn wants(&self, workload: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|name| workload.starts_with(name.as_str()))
    }
}
