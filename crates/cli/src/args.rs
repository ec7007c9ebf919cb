//! What can be typed.

use clap::{Parser, Subcommand};
use std::path::PathBuf;
use truepose_solvers::SolverSpec;

/// Finds out why a robot arm does not go where it is told, and makes it go there.
#[derive(Debug, Parser)]
#[command(name = "truepose", version, max_term_width = 100)]
pub struct Args {
    /// Threads to use; results do not depend on it [default: all cores]
    #[arg(long, global = true, display_order = 900, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// End after so long, with what was found so far, e.g. 10min (exit code 3)
    #[arg(long, global = true, display_order = 901, value_name = "TIME", value_parser = crate::watch::parse_time)]
    pub time_limit: Option<std::time::Duration>,
    /// End when more memory is in use, with what was found so far, e.g. 2GB (exit code 3)
    #[arg(long, global = true, display_order = 902, value_name = "SIZE", value_parser = crate::watch::parse_memory)]
    pub memory_limit: Option<u64>,
    /// What to do
    #[command(subcommand)]
    pub verb: Verb,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Fit a declared error model to measured poses, and say what it is worth
    Identify(Identify),
    /// Find what a declared model lacks: name it, add it, and prove the gain on held-out data
    Discover(Discover),
    /// Say what to measure next: for accuracy, or to tell two explanations apart
    Plan(Plan),
    /// Predict where the real robot is, from a fit
    Predict(Predict),
    /// Compute the joint commands that bring the real robot to desired poses
    Compensate(Compensate),
    /// Write the fitted geometry as a URDF, a table of axes, a kinematics file, or tables of component errors
    Export(Export),
    /// Map the robot's accuracy over its workspace, before and after compensation
    Map(Map),
    /// Fit one model with several solver strategies, on the same folds, and test the differences
    Compare(Compare),
    /// Read files and say what was understood: every unit, range and count
    Check(Check),
    /// List the effects and solvers that can be declared
    Effects(Effects),
    /// Measure a simulated robot with real physics, and write what a laser tracker would have written
    Simulate(Simulate),
    /// Repeat a run from the run.json of its report, and compare the results
    Verify(Verify),
}

/// Which robot.
#[derive(Debug, clap::Args)]
pub struct Robot {
    /// Robot description (.toml or .urdf)
    #[arg(long, value_name = "FILE")]
    pub robot: PathBuf,
    /// Base link of a URDF [default: its root]
    #[arg(long, value_name = "LINK")]
    pub base: Option<String>,
    /// Tip link of a URDF [default: its only leaf]
    #[arg(long, value_name = "LINK")]
    pub tip: Option<String>,
}

/// `truepose identify`
#[derive(Debug, clap::Args)]
pub struct Identify {
    #[command(flatten)]
    pub robot: Robot,
    /// Measurements (CSV)
    #[arg(long, value_name = "FILE")]
    pub data: PathBuf,
    /// Declared model (TOML) [default: constant errors of every frame and target]
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Where to write the fit
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Solver, with its options in brackets: normal, qr, svd(rcond=1e-10), ridge(gcv), huber(qr, k=1.345), …
    #[arg(long, default_value = "qr")]
    pub solver: SolverSpec,
    /// Folds of the cross-validation; 0 for none
    #[arg(long, default_value_t = 5)]
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
    #[arg(long, default_value_t = 0)]
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
    /// Read the data block by block, in memory that does not grow with it: for files larger than memory
    #[arg(long, conflicts_with_all = ["split", "repeat", "fold_by", "holdout", "report", "spec"])]
    pub stream: bool,
    /// Folder for the report: `index.html`, its figures, `identification.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Specification to hold poses against that the fit did not see, e.g. 0.5mm
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub spec: Option<f64>,
    /// Fail with exit code 1 when the held-out RMS is above this, e.g. 0.15mm
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub require: Option<f64>,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose discover`
#[derive(Debug, clap::Args)]
pub struct Discover {
    #[command(flatten)]
    pub robot: Robot,
    /// Measurements (CSV)
    #[arg(long, value_name = "FILE")]
    pub data: PathBuf,
    /// Declared model (TOML) [default: constant errors of every frame and target]
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Where to write the enlarged fit
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Folder for the report: `index.html`, its figures, `discovery.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Specification to hold held-out poses against, e.g. 0.5mm
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
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
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Family-wise probability above which a find is taken for chance
    #[arg(long, default_value_t = 0.002)]
    pub alpha: f64,
    /// Sign flips behind each p-value
    #[arg(long, default_value_t = 999)]
    pub flips: usize,
    /// Judge the loop itself as well: run the whole of it with each of so many folds left out
    #[arg(long, value_name = "FOLDS", value_parser = clap::value_parser!(u16).range(2..=100))]
    pub nested: Option<u16>,
    /// How configurations are divided into those folds
    #[arg(long, value_enum, default_value_t = SplitKind::Random)]
    pub split: SplitKind,
    /// Effects to find at most
    #[arg(long, default_value_t = 24)]
    pub most: usize,
    /// Use measured positions alone, even where orientations were measured
    #[arg(long)]
    pub positions_only: bool,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose plan`
#[derive(Debug, clap::Args)]
pub struct Plan {
    /// A fit, as `identify` or `discover` writes it
    #[arg(long, value_name = "FILE")]
    pub fit: PathBuf,
    /// Another explanation of the same robot: plan the visits that tell the two apart
    #[arg(long, value_name = "FILE", alias = "discriminate")]
    pub rival: Option<PathBuf>,
    /// Joints, loads and channels (CSV) where accuracy matters [default: spread over the joints' ranges]
    #[arg(long, value_name = "FILE")]
    pub at: Option<PathBuf>,
    /// Where to write the plan (CSV, in the columns of measurements)
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Visits
    #[arg(long, default_value_t = 30)]
    pub count: usize,
    /// Payloads that can be put on, kg [default: none]
    #[arg(long, value_name = "KG", value_delimiter = ',', allow_negative_numbers = true)]
    pub loads: Vec<f64>,
    /// Their centre of gravity in the tool frame, mm
    #[arg(long, value_name = "MM", num_args = 3, value_delimiter = ',', allow_negative_numbers = true, default_values_t = [0.0, 0.0, 0.0])]
    pub com: Vec<f64>,
    /// Configurations among which is chosen
    #[arg(long, default_value_t = 400)]
    pub pool: usize,
    /// Seed of those configurations
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
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

/// `truepose compensate`
#[derive(Debug, clap::Args)]
pub struct Compensate {
    /// A fit, as `identify` writes it
    #[arg(long, value_name = "FILE")]
    pub fit: PathBuf,
    /// Desired poses (CSV): x y z, optional orientation, target, load, channels, time, approach; joints as the seed
    #[arg(long, value_name = "FILE")]
    pub poses: PathBuf,
    /// Where to write the commands
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Folder for the report: `index.html`, its figures, `compensation.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose export`
#[derive(Debug, clap::Args)]
pub struct Export {
    /// A fit, as `identify` writes it
    #[arg(long, value_name = "FILE")]
    pub fit: PathBuf,
    /// What to write
    #[arg(long, value_enum)]
    pub format: ExportFormat,
    /// Where to write it
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// The URDF that the fit was made from: its joint origins are corrected, everything else stays as it is
    #[arg(long, value_name = "FILE")]
    pub urdf: Option<PathBuf>,
    /// Refuse nearly parallel axes in dh and mdh, instead of using Hayati's parameter (beta)
    #[arg(long)]
    pub no_hayati: bool,
    /// Values of each joint in iso230
    #[arg(long, default_value_t = 181, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub entries: u32,
    /// The target at which the error left is judged [default: the tool's origin]
    #[arg(long, value_name = "NAME")]
    pub target: Option<String>,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// Forms of the fitted geometry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ExportFormat {
    /// URDF with corrected joint origins
    Urdf,
    /// Denavit and Hartenberg's table (CSV)
    Dh,
    /// Craig's modified table (CSV)
    Mdh,
    /// Kinematics file of ROS drivers (YAML): x y z roll pitch yaw of each joint
    Ros,
    /// Component errors of each joint in the way of ISO 230-1 (CSV)
    Iso230,
}

/// `truepose map`
#[derive(Debug, clap::Args)]
pub struct Map {
    /// A fit, as `identify` writes it
    #[arg(long, value_name = "FILE")]
    pub fit: PathBuf,
    /// Where to write the map (CSV)
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// A corner of a box in the measurement frame, e.g. -500mm,0mm,200mm [default: a grid of joint values]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_position, requires = "to", allow_hyphen_values = true)]
    pub from: Option<[f64; 3]>,
    /// The opposite corner
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_position, requires = "from", allow_hyphen_values = true)]
    pub to: Option<[f64; 3]>,
    /// Orientation of the tool in the box: roll, pitch, yaw about the fixed axes, degrees [default: any]
    #[arg(long, value_name = "R,P,Y", value_parser = parse_three, requires = "from", allow_hyphen_values = true)]
    pub rpy: Option<[f64; 3]>,
    /// Values of each joint, or of each coordinate of the box
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub points: u16,
    /// Mass carried, kg
    #[arg(long, allow_negative_numbers = true, value_name = "KG")]
    pub payload: Option<f64>,
    /// Its centre of gravity in the tool's frame, e.g. 0mm,0mm,80mm
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_position, requires = "payload", allow_hyphen_values = true)]
    pub com: Option<[f64; 3]>,
    /// The target that is mapped [default: the tool's origin]
    #[arg(long, value_name = "NAME")]
    pub target: Option<String>,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose compare`
#[derive(Debug, clap::Args)]
pub struct Compare {
    #[command(flatten)]
    pub robot: Robot,
    /// Measurements (CSV)
    #[arg(long, value_name = "FILE")]
    pub data: PathBuf,
    /// Declared model (TOML) [default: constant errors of every frame and target]
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// A strategy; give the option once for each
    #[arg(long = "solver", value_name = "SOLVER",
          default_values = ["qr", "svd", "normal", "ridge(gcv)", "ridge(map)", "lasso(cv)", "huber(qr)", "tukey(qr)"])]
    pub solvers: Vec<SolverSpec>,
    /// Folds of the cross-validation
    #[arg(long, default_value_t = 5)]
    pub folds: usize,
    /// How configurations are divided into folds
    #[arg(long, value_enum, default_value_t = SplitKind::Random)]
    pub split: SplitKind,
    /// Seed of every random choice
    #[arg(long, default_value_t = 0)]
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

/// `truepose predict`
#[derive(Debug, clap::Args)]
pub struct Predict {
    /// A fit, as `identify` writes it
    #[arg(long, value_name = "FILE")]
    pub fit: PathBuf,
    /// Joints, loads and channels (CSV); measured columns may be empty or absent
    #[arg(long, value_name = "FILE")]
    pub data: PathBuf,
    /// Where to write the predictions
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

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
    #[arg(long)]
    pub seed: Option<u64>,
    /// Visit other configurations than the plant's own, drawn from this seed; the robot stays the same
    #[arg(long, value_name = "SEED")]
    pub campaign_seed: Option<u64>,
}

/// `truepose verify`
#[derive(Debug, clap::Args)]
pub struct Verify {
    /// The record of the run, `run.json` in its report's folder; run it in the folder in which the run was made
    #[arg(value_name = "FILE")]
    pub run: PathBuf,
}

fn parse_prior(text: &str) -> Result<truepose_identify::PriorStrength, String> {
    use truepose_identify::PriorStrength;
    match text {
        "evidence" => Ok(PriorStrength::Kinds),
        "none" => Ok(PriorStrength::None),
        _ => match text.parse::<f64>() {
            Ok(kappa) if kappa.is_finite() && kappa > 0.0 => Ok(PriorStrength::Fixed(kappa)),
            _ => Err("expected `evidence`, `none` or a number above 0".into()),
        },
    }
}

/// `0.15mm`, `150um`, `0.006in`; metres.
fn parse_length(text: &str) -> Result<f64, String> {
    let value = length(text)?;
    if value > 0.0 { Ok(value) } else { Err("a length above 0 is needed".into()) }
}

/// `-500mm,0mm,0.2m`; metres.
fn parse_position(text: &str) -> Result<[f64; 3], String> {
    three(text, length)
}

/// Three numbers.
fn parse_three(text: &str) -> Result<[f64; 3], String> {
    three(text, |part| match part.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{part}` is not a number")),
    })
}

fn three(text: &str, one: impl Fn(&str) -> Result<f64, String>) -> Result<[f64; 3], String> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    match parts[..] {
        [x, y, z] => Ok([one(x)?, one(y)?, one(z)?]),
        _ => Err(format!("three values with commas between them are needed, not {}", parts.len())),
    }
}

fn length(text: &str) -> Result<f64, String> {
    let split = text.find(|c: char| c.is_ascii_alphabetic() && c != 'e' && c != 'E').unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let value: f64 = number.trim().parse().map_err(|_| format!("`{number}` is not a number"))?;
    let unit = truepose_io::Unit::named(unit.trim())
        .filter(|unit| unit.quantity == truepose_io::Quantity::Length)
        .ok_or("a length needs a unit: m, mm, um or in, as in 0.15mm")?;
    if value.is_finite() { Ok(unit.to_si(value)) } else { Err("a finite length is needed".into()) }
}
