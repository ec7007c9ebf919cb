//! Verbs beside the work: looking at files, making them up, repeating a run.

use super::values::parse_whole;
use super::{Grouped, Robot};
use std::path::PathBuf;

/// `truepose check`
#[derive(Debug, clap::Args)]
pub struct Check {
    #[command(flatten)]
    pub robot: Robot,
    /// Measurements (CSV)
    #[arg(long, value_name = "FILE")]
    pub data: Option<PathBuf>,
    /// Declared model (TOML)
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    #[command(flatten)]
    pub grouped: Grouped,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose effects`
#[derive(Debug, clap::Args)]
pub struct Effects {
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose simulate`
#[derive(Debug, clap::Args)]
pub struct Simulate {
    /// The robot's file, what is wrong with it, and what is measured (TOML)
    #[arg(long, value_name = "FILE")]
    pub plant: PathBuf,
    /// Where to write the measurements (CSV, mm and degrees)
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Another seed than the plant's own
    #[arg(long, value_parser = parse_whole::<u64>)]
    pub seed: Option<u64>,
    /// Visit other configurations than the plant's own, drawn from this seed; the robot stays the same
    #[arg(long, value_name = "SEED", value_parser = parse_whole::<u64>)]
    pub campaign_seed: Option<u64>,
}

/// `truepose verify`
#[derive(Debug, clap::Args)]
pub struct Verify {
    /// The record of the run, `run.json` in its report's folder; run it in the folder in which the run was made
    #[arg(value_name = "FILE")]
    pub run: PathBuf,
}
