//! What can be typed.

use crate::workload::Failure;
use std::path::PathBuf;

/// Everything that was typed, and where things are.
#[derive(Debug, Clone)]
pub struct Arguments {
    /// Workloads to run; all when empty. `W3` stands for all that begin so; `growth`, `discover` or `breadth` alone is no workload but how time grows.
    pub only: Vec<String>,
    /// How often both sides are run in turn.
    pub rounds: usize,
    /// Results of an earlier run, to compare with.
    pub against: Option<PathBuf>,
    /// Where the results go.
    pub out: PathBuf,
    /// Where the figure of growth goes.
    pub figure: PathBuf,
    /// Rows up to which `discover` is run.
    pub most_rows: usize,
    /// Joints up to which `breadth` is run.
    pub most_joints: usize,
    /// One way of one workload, for a parent process: `W1 gram`.
    pub serve: Option<(String, String)>,
    /// Threads of our side.
    pub threads: usize,
    /// The folder of the peers' scripts.
    pub peers: PathBuf,
    /// Python with the peers' packages.
    pub python: PathBuf,
    /// The folder of the peers' data.
    pub data: PathBuf,
}

impl Arguments {
    /// Reads the command line and the environment.
    pub fn read() -> Result<Self, Failure> {
        let target =
            std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from);
        let from = |name: &str, otherwise: PathBuf| std::env::var_os(name).map_or(otherwise, PathBuf::from);
        let mut read = Arguments {
            only: Vec::new(),
            rounds: 7,
            against: None,
            out: target.join("bench").join("results.json"),
            figure: PathBuf::from("docs/figures/growth.svg"),
            most_rows: 1_000_000,
            most_joints: 30,
            serve: None,
            threads: 1,
            peers: from("TRUEPOSE_PEERS", PathBuf::from("../shared/peers")),
            python: from("TRUEPOSE_PEERS_PYTHON", target.join("peers-venv/bin/python")),
            data: from("TRUEPOSE_PEERS_DATA", target.join("bench").join("data")),
        };
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut next = || words.next().ok_or(format!("`{word}` wants a value"));
            match word.as_str() {
                "--rounds" => read.rounds = next()?.parse::<usize>()?.max(1),
                "--threads" => read.threads = next()?.parse::<usize>()?.max(1),
                "--most-rows" => read.most_rows = next()?.parse()?,
                "--most-joints" => read.most_joints = next()?.parse()?,
                "--against" => read.against = Some(PathBuf::from(next()?)),
                "--out" => read.out = PathBuf::from(next()?),
                "--figure" => read.figure = PathBuf::from(next()?),
                "--serve" => read.serve = Some((next()?, next()?)),
                other if other.starts_with('-') => return Err(format!("`{other}` is not an option").into()),
                _ => read.only.push(word),
            }
        }
        Ok(read)
    }

    /// Whether a workload was asked for.
    pub fn wants(&self, workload: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|name| workload.starts_with(name.as_str()))
    }
}
