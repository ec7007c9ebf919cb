//! Options of `truepose dwell`.

use super::files::{Input, Output};
use super::grouped::parse_tolerance;
use super::values::{parse_signed_time, parse_time};
use super::{NamedColumns, Robot};
use std::time::Duration;
use truepose_errormodel::DwellTolerance;

/// `truepose dwell`
#[derive(Debug, clap::Args)]
pub struct DwellOf {
    /// Log (CSV, Parquet or Excel): joints, measured positions and time[s] in each row, the robot moving or not
    #[arg(value_name = "LOG")]
    pub log: Input,
    #[command(flatten)]
    pub robot: Robot,
    /// Where to write the measurements: one row for each target in each dwell (CSV, mm and degrees)
    #[arg(long, value_name = "FILE")]
    pub out: Output,
    /// How far a joint moves at most while the robot stands still, within a fifth of the dwell: an angle, a length, or both
    /// [default: 2e-4rad,0.2mm]
    #[arg(long, value_name = "ANGLE,LENGTH", allow_hyphen_values = true, value_parser = parse_tolerance)]
    pub still: Option<DwellTolerance>,
    /// How long a dwell lasts at least
    #[arg(long, value_name = "TIME", default_value = "0.5s", allow_hyphen_values = true, value_parser = parse_time)]
    pub dwell: Duration,
    /// Time at the beginning of each dwell that is left out
    #[arg(long, value_name = "TIME", default_value = "0.2s", allow_hyphen_values = true, value_parser = parse_signed_time)]
    pub settle: f64,
    /// By how much the instrument's rows are late against the joints, e.g. 35ms [default: found from the data]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = parse_signed_time)]
    pub lag: Option<f64>,
    #[command(flatten)]
    pub named: NamedColumns,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}
