//! Options of the verbs that fit nothing: check, effects, simulate, verify.

use super::files::{Input, Output};
use super::values::parse_whole;
use super::{Grouped, Robot};

/// `truepose check`
#[derive(Debug, clap::Args)]
pub struct Check {
    #[command(flatten)]
    pub robot: Robot,
    /// Measurements (CSV)
    #[arg(long, value_name = "FILE")]
    pub data: Option<Input>,
    /// Declared model (TOML)
    #[arg(long, value_name = "FILE")]
    pub model: Option<Input>,
    #[command(flatten)]
    pub grouped: Grouped,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose init`
#[derive(Debug, clap::Args)]
pub struct Init {
    /// A robot of the library, e.g. ur10e (`--list` lists them)
    #[arg(required_unless_present_any = ["list", "dh"])]
    pub name: Option<String>,
    /// List the robots of the library
    #[arg(long)]
    pub list: bool,
    /// A robot that is not in the library: a description with N rows of Denavit-Hartenberg parameters to fill in
    #[arg(long, value_name = "N", conflicts_with_all = ["name", "list"], value_parser = clap::value_parser!(u16).range(1..=256))]
    pub dh: Option<u16>,
    /// Where to write the robot description [default: NAME.toml; of --dh: robot.toml]
    #[arg(long, value_name = "FILE")]
    pub out: Option<Output>,
    /// Where to write a table for the measurements (CSV, with its header alone)
    #[arg(long, value_name = "FILE")]
    pub csv: Option<Output>,
}

/// `truepose effects`
#[derive(Debug, clap::Args)]
pub struct Effects {
    /// One family in depth: law, parameters with units, example, what it is confused with, what to look at
    #[arg(value_name = "FAMILY")]
    pub family: Option<String>,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose simulate`
#[derive(Debug, clap::Args)]
pub struct Simulate {
    /// Plant (TOML): the robot's file, its error sources, what it is measured with, and the measurement campaign
    #[arg(long, value_name = "FILE")]
    pub plant: Input,
    /// Where to write the measurements (CSV, mm and degrees)
    #[arg(long, value_name = "FILE")]
    pub out: Output,
    /// Where to write the true position of every row's target and the true orientation of the tool, without noise (CSV)
    #[arg(long, value_name = "FILE")]
    pub truth: Option<Output>,
    /// Seed of every random choice [default: that of the plant]
    #[arg(long, value_parser = parse_whole::<u64>)]
    pub seed: Option<u64>,
    /// Draw other configurations from this seed; the robot stays the same
    #[arg(long, value_name = "SEED", value_parser = parse_whole::<u64>)]
    pub campaign_seed: Option<u64>,
}

/// `truepose verify`
#[derive(Debug, clap::Args)]
pub struct Verify {
    /// Record of the run, `run.json` in the folder of its report; to be used in the folder in which the run was made
    #[arg(value_name = "FILE")]
    pub run: Input,
}

/// `truepose completions`
#[derive(Debug, clap::Args)]
pub struct Completions {
    /// The shell, or `man`
    #[arg(value_enum)]
    pub of: CompletionsOf,
}

/// What is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum CompletionsOf {
    /// For bash
    Bash,
    /// For zsh
    Zsh,
    /// For fish
    Fish,
    /// For PowerShell
    Powershell,
    /// For elvish
    Elvish,
    /// The manual page, in roff
    Man,
}
