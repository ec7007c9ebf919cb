//! Verbs that learn from measurements.

use super::values::{parse_count, parse_length, parse_prior, parse_whole};
use super::{Grouped, Robot};
use std::path::PathBuf;
use truepose_identify::FitOptions;
use truepose_solvers::SolverSpec;

/// What was measured of which robot, and what is declared of it.
#[derive(Debug, clap::Args)]
pub struct Measured {
    #[command(flatten)]
    pub robot: Robot,
    /// Measurements (CSV)
    #[arg(long, value_name = "FILE")]
    pub data: PathBuf,
    /// Declared model (TOML) [default: constant errors of every frame and target]
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    #[command(flatten)]
    pub grouped: Grouped,
}

/// `truepose identify`
#[derive(Debug, clap::Args)]
pub struct Identify {
    #[command(flatten)]
    pub measured: Measured,
    /// Where to write the fit
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Solver, with its options in brackets: normal, qr, svd(rcond=1e-10), ridge(gcv), huber(qr, k=1.345), …
    #[arg(long, default_value = "qr")]
    pub solver: SolverSpec,
    /// Folds of the cross-validation; 0 for none
    #[arg(long, default_value_t = 5, value_parser = parse_whole::<usize>)]
    pub folds: usize,
    /// How configurations are divided into folds
    #[arg(long, value_enum, default_value_t = SplitKind::Random)]
    pub split: SplitKind,
    /// Draw the random folds this often, and report mean and spread
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub repeat: u16,
    /// Folds of your own: a channel of the data whose values number them, one value a visit
    #[arg(long, value_name = "CHANNEL", conflicts_with_all = ["split", "repeat"])]
    pub fold_by: Option<String>,
    /// Seed of every random choice
    #[arg(long, default_value_t = 0, value_parser = parse_whole::<u64>)]
    pub seed: u64,
    /// Share of the configurations to lock away first and judge by
    #[arg(long, value_name = "SHARE")]
    pub holdout: Option<f64>,
    /// Use measured positions alone, even where orientations were measured
    #[arg(long)]
    pub positions_only: bool,
    /// How coefficients are held to their expected sizes: evidence, none, or a number of expected sizes
    #[arg(long, default_value = "evidence", value_parser = parse_prior)]
    pub prior: truepose_identify::PriorStrength,
    /// The paper's single linear step, without refinement at the exact model
    #[arg(long)]
    pub linear: bool,
    /// Decide once, at the nominal robot, which errors can be told apart, as the paper does; otherwise the robot as it is found is looked at
    /// again
    #[arg(long)]
    pub reduce_once: bool,
    /// Rounds of the refinement at most
    #[arg(long, value_name = "ROUNDS", default_value_t = FitOptions::default().max_iterations, value_parser = parse_count)]
    pub rounds: usize,
    /// Read the data block by block, in memory that does not grow with it: for files larger than memory
    #[arg(long, conflicts_with_all = ["split", "repeat", "fold_by", "holdout", "report", "spec"])]
    pub stream: bool,
    /// Folder for the report: `index.html`, its figures, `identification.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Specification to hold poses against that the fit did not see, e.g. 0.5mm
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = parse_length)]
    pub spec: Option<f64>,
    /// Fail with exit code 1 when the held-out RMS is above this, e.g. 0.15mm
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = parse_length)]
    pub require: Option<f64>,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

impl Identify {
    /// How to fit.
    pub fn fit(&self) -> FitOptions {
        FitOptions {
            refine: !self.linear,
            second_reduction: !self.reduce_once,
            max_iterations: self.rounds,
            prior: self.prior,
            ..FitOptions::default()
        }
    }
}

/// How configurations are divided into folds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum SplitKind {
    /// At random
    Random,
    /// Contiguous blocks in time
    Time,
    /// Slabs along the joint that moves most
    Joint,
    /// One configuration at a time
    LeaveOneOut,
}

/// `truepose discover`
#[derive(Debug, clap::Args)]
pub struct Discover {
    #[command(flatten)]
    pub measured: Measured,
    /// Where to write the enlarged fit
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Folder for the report: `index.html`, its figures, `discovery.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Specification to hold held-out poses against, e.g. 0.5mm
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = parse_length)]
    pub spec: Option<f64>,
    /// Folder for fits of the explanations that the data cannot tell from what was found: rivals for `truepose plan`
    #[arg(long, value_name = "DIR")]
    pub rivals: Option<PathBuf>,
    /// Solver, with its options in brackets: normal, qr, svd(rcond=1e-10), …
    #[arg(long, default_value = "qr")]
    pub solver: SolverSpec,
    /// Share of the configurations that is drawn first and takes part in nothing
    #[arg(long, value_name = "SHARE", default_value_t = 0.2)]
    pub holdout: f64,
    /// Seed of every random choice
    #[arg(long, default_value_t = 0, value_parser = parse_whole::<u64>)]
    pub seed: u64,
    /// Family-wise probability above which a find is taken for chance
    #[arg(long, default_value_t = 0.002)]
    pub alpha: f64,
    /// Sign flips behind each p-value
    #[arg(long, default_value_t = 999, value_parser = parse_whole::<usize>)]
    pub flips: usize,
    /// Judge the loop itself as well: run the whole of it with each of so many folds left out
    #[arg(long, value_name = "FOLDS", value_parser = clap::value_parser!(u16).range(2..=100))]
    pub nested: Option<u16>,
    /// How configurations are divided into those folds
    #[arg(long, value_enum, default_value_t = SplitKind::Random)]
    pub split: SplitKind,
    /// Effects to find at most
    #[arg(long, default_value_t = 24, value_parser = parse_whole::<usize>)]
    pub most: usize,
    /// Use measured positions alone, even where orientations were measured
    #[arg(long)]
    pub positions_only: bool,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose compare`
#[derive(Debug, clap::Args)]
pub struct Compare {
    #[command(flatten)]
    pub measured: Measured,
    /// A strategy; give the option once for each
    #[arg(long = "solver", value_name = "SOLVER",
          default_values = ["qr", "svd", "normal", "ridge(gcv)", "ridge(map)", "lasso(cv)", "huber(qr)", "tukey(qr)"])]
    pub solvers: Vec<SolverSpec>,
    /// Folds of the cross-validation
    #[arg(long, default_value_t = 5, value_parser = parse_whole::<usize>)]
    pub folds: usize,
    /// How configurations are divided into folds
    #[arg(long, value_enum, default_value_t = SplitKind::Random)]
    pub split: SplitKind,
    /// Seed of every random choice
    #[arg(long, default_value_t = 0, value_parser = parse_whole::<u64>)]
    pub seed: u64,
    /// Use measured positions alone, even where orientations were measured
    #[arg(long)]
    pub positions_only: bool,
    /// Folder for the report: `index.html`, its figures, `comparison.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// A prior on top of every strategy: evidence, none, or a number of expected sizes
    #[arg(long, default_value = "none", value_parser = parse_prior)]
    pub prior: truepose_identify::PriorStrength,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}
