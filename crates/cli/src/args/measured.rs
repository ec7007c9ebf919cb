//! Options of the verbs that fit measurements: identify, discover, compare.

use super::files::{Input, Output, OutputFolder, Prior};
use super::values::{
    parse_count, parse_fraction, parse_length, parse_prior, parse_prior_or_fleet, parse_whole,
};
use super::{Grouped, Robot};
use crate::extensions::SolverChoice;
use truepose_identify::FitOptions;
use truepose_workflow::InputFiles;

/// Robot, measurements and declared model.
#[derive(Debug, clap::Args)]
pub struct Measured {
    #[command(flatten)]
    pub robot: Robot,
    /// Measurements (CSV)
    #[arg(long, value_name = "FILE")]
    pub data: Input,
    /// Declared model (TOML) [default: constant errors of every frame and target]
    #[arg(long, value_name = "FILE")]
    pub model: Option<Input>,
    #[command(flatten)]
    pub grouped: Grouped,
}

impl Measured {
    /// The files, and how they are read.
    pub fn files(&self, positions_only: bool) -> InputFiles {
        InputFiles {
            data: self.data.to_path_buf(),
            model: self.model.as_ref().map(|model| model.to_path_buf()),
            reading: self.grouped.measured(),
            positions_only,
            ..self.robot.files()
        }
    }
}

/// `truepose identify`
#[derive(Debug, clap::Args)]
pub struct Identify {
    #[command(flatten)]
    pub measured: Measured,
    /// Where to write the fit
    #[arg(long, value_name = "FILE")]
    pub out: Option<Output>,
    /// Where to write the parameters of the robot as it is described: nominal, calibrated, 95 % interval (CSV)
    #[arg(long, value_name = "FILE")]
    pub parameters: Option<Output>,
    /// Solver, with its options in brackets: normal, qr, svd(rcond=1e-10), ridge(gcv), huber(qr, k=1.345), …
    #[arg(long, default_value = "qr")]
    pub solver: SolverChoice,
    /// Folds of the cross-validation; 0 for none
    #[arg(long, default_value_t = 5, value_parser = parse_whole::<usize>)]
    pub folds: usize,
    /// How configurations are divided into folds
    #[arg(long, value_enum, default_value_t = SplitKind::Random)]
    pub split: SplitKind,
    /// Repeat the cross-validation with this many random splits, and report mean and standard deviation
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub repeat: u16,
    /// Channel of the data that numbers the folds, one value for each pose measurement
    #[arg(long, value_name = "CHANNEL", conflicts_with_all = ["split", "repeat"])]
    pub fold_by: Option<String>,
    /// Seed of every random choice
    #[arg(long, default_value_t = 0, value_parser = parse_whole::<u64>)]
    pub seed: u64,
    /// Fraction of the configurations for a held-out test set, drawn before anything is fitted, e.g. 20%
    #[arg(long, value_name = "FRACTION", allow_hyphen_values = true, value_parser = parse_fraction)]
    pub holdout: Option<f64>,
    /// Use measured positions alone, even where orientations were measured
    #[arg(long)]
    pub positions_only: bool,
    /// Scale of the prior standard deviations towards which coefficients are shrunk: evidence (from the marginal likelihood), none, or
    /// a factor; or a file of `truepose fleet` (JSON): robots of this type as prior
    #[arg(long, default_value = "evidence", value_parser = parse_prior_or_fleet)]
    pub prior: Prior,
    /// A single linear least-squares step, as in the paper, without iteration at the exact model
    #[arg(long)]
    pub linear: bool,
    /// Determine the identifiable errors once, at the nominal robot, as in the paper [default: again at the fitted robot]
    #[arg(long)]
    pub reduce_once: bool,
    /// Largest number of iterations
    #[arg(long, value_name = "ROUNDS", default_value_t = FitOptions::default().max_iterations, value_parser = parse_count)]
    pub rounds: usize,
    /// Read the data block by block, for files larger than memory
    #[arg(long, conflicts_with_all = ["split", "repeat", "fold_by", "holdout", "report", "spec", "parameters"])]
    pub stream: bool,
    /// Folder for the report: `index.html`, its figures, `identification.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<OutputFolder>,
    /// File with the head of the report, [certificate] (TOML) [default: the robot file]
    #[arg(long, value_name = "FILE", requires = "report")]
    pub certificate: Option<Input>,
    /// Specification of the 3-D position error, compared with held-out poses, e.g. 0.5mm; exit code 1 when they fail
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = parse_length)]
    pub spec: Option<f64>,
    /// What will be done with the result: the verdict of --spec is of the robot after that
    #[arg(long, value_enum, default_value_t = Corrected::None, requires = "spec")]
    pub correction: Corrected,
    /// Fail with exit code 1 when the held-out RMS is above this, e.g. 0.15mm
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = parse_length)]
    pub require: Option<f64>,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

impl Identify {
    /// Options of the fit.
    pub fn fit(&self) -> FitOptions {
        FitOptions {
            refine: !self.linear,
            second_reduction: !self.reduce_once,
            max_iterations: self.rounds,
            prior: self.prior.strength(),
            ..FitOptions::default()
        }
    }
}

/// What is done with the result of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Corrected {
    /// Nothing: the robot stays as it is
    None,
    /// The constants of the controller are corrected
    Constants,
    /// Each command is corrected (truepose compensate, or the fit in the controller)
    Commands,
}

impl From<Corrected> for truepose_report::Correction {
    fn from(of: Corrected) -> Self {
        match of {
            Corrected::None => Self::None,
            Corrected::Constants => Self::Constants,
            Corrected::Commands => Self::Commands,
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

impl From<SplitKind> for truepose_workflow::SplitKind {
    fn from(of: SplitKind) -> Self {
        match of {
            SplitKind::Random => Self::Random,
            SplitKind::Time => Self::Time,
            SplitKind::Joint => Self::Joint,
            SplitKind::LeaveOneOut => Self::LeaveOneOut,
        }
    }
}

/// `truepose discover`
#[derive(Debug, clap::Args)]
pub struct Discover {
    #[command(flatten)]
    pub measured: Measured,
    /// Where to write the enlarged fit
    #[arg(long, value_name = "FILE")]
    pub out: Option<Output>,
    /// Folder for the report: `index.html`, its figures, `discovery.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<OutputFolder>,
    /// File with the head of the report, [certificate] (TOML) [default: the robot file]
    #[arg(long, value_name = "FILE", requires = "report")]
    pub certificate: Option<Input>,
    /// Specification of the 3-D position error, compared with held-out poses, e.g. 0.5mm; exit code 1 when they fail
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = parse_length)]
    pub spec: Option<f64>,
    /// What will be done with the result: the verdict of --spec is of the robot after that
    #[arg(long, value_enum, default_value_t = Corrected::None, requires = "spec")]
    pub correction: Corrected,
    /// Folder for fits of the competing hypotheses that are not distinguishable from the findings, for `truepose plan --rival`
    #[arg(long, value_name = "DIR")]
    pub rivals: Option<OutputFolder>,
    /// Where to write the parameters of the robot as it is described: nominal, calibrated, 95 % interval (CSV)
    #[arg(long, value_name = "FILE")]
    pub parameters: Option<Output>,
    /// Solver, with its options in brackets: normal, qr, svd(rcond=1e-10), …
    #[arg(long, default_value = "qr")]
    pub solver: SolverChoice,
    /// Fraction of the configurations in the held-out test set, drawn before anything is fitted [default: 0.2;
    /// none where poses are few: then nested cross-validation takes its place]
    #[arg(long, value_name = "FRACTION", allow_hyphen_values = true, value_parser = parse_fraction)]
    pub holdout: Option<f64>,
    /// Seed of every random choice
    #[arg(long, default_value_t = 0, value_parser = parse_whole::<u64>)]
    pub seed: u64,
    /// Family-wise significance level: a candidate with a larger p-value is not added
    #[arg(long, default_value_t = 0.002)]
    pub alpha: f64,
    /// Random rotations behind each family-wise p-value
    #[arg(long, alias = "flips", default_value_t = 499, value_parser = parse_whole::<usize>)]
    pub rotations: usize,
    /// Nested cross-validation: repeat the whole search with each of this many folds left out
    #[arg(long, value_name = "FOLDS", value_parser = clap::value_parser!(u16).range(2..=100))]
    pub nested: Option<u16>,
    /// How configurations are divided into the folds of --nested
    #[arg(long, value_enum, default_value_t = SplitKind::Random)]
    pub split: SplitKind,
    /// Largest number of effects to add
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
    /// A solver strategy; repeat the option for each
    #[arg(long = "solver", value_name = "SOLVER",
          default_values = ["qr", "svd", "normal", "ridge(gcv)", "ridge(map)", "lasso(cv)", "huber(qr)", "tukey(qr)"])]
    pub solvers: Vec<SolverChoice>,
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
    pub report: Option<OutputFolder>,
    /// Scale of the prior standard deviations, for every strategy: evidence (from the marginal likelihood), none, or a factor
    #[arg(long, default_value = "none", value_parser = parse_prior)]
    pub prior: truepose_identify::PriorStrength,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}
