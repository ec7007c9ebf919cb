//! Options of the verbs that hold new measurements against a fit: transfer, monitor.

use super::files::{Input, Output, OutputFolder, Record};
use super::values::{parse_date, parse_length};
use super::{Accept, Grouped};

/// `truepose transfer`
#[derive(Debug, clap::Args)]
pub struct Transfer {
    /// A fit, as `identify` or `discover` writes it
    #[arg(long, value_name = "FILE")]
    pub fit: Input,
    #[command(flatten)]
    pub accept: Accept,
    /// Measurements in the new installation (CSV): a few poses
    #[arg(long, value_name = "FILE")]
    pub data: Input,
    #[command(flatten)]
    pub grouped: Grouped,
    /// Where to write the fit of the new installation
    #[arg(long, value_name = "FILE")]
    pub out: Output,
    /// Find the tool as well
    #[arg(long)]
    pub tool: bool,
    /// Find the positions of the measured targets as well
    #[arg(long)]
    pub targets: bool,
    /// Let the errors of the arm move within their uncertainty (Bayesian update)
    #[arg(long)]
    pub update: bool,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose fleet`
#[derive(Debug, clap::Args)]
pub struct Fleet {
    /// Fits of robots of one type, made with one model
    #[arg(value_name = "FIT", required = true)]
    pub fits: Vec<Input>,
    /// Where to write the prior for the next robot of that type (JSON): `identify --prior`
    #[arg(long, value_name = "FILE")]
    pub out: Output,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose monitor`
#[derive(Debug, clap::Args)]
pub struct Monitor {
    /// The fit of the robot as it was calibrated
    #[arg(long, value_name = "FILE")]
    pub fit: Input,
    #[command(flatten)]
    pub accept: Accept,
    /// Which of its sessions the robot is in, of a fit that knows several
    #[arg(long, value_name = "NAME")]
    pub session: Option<String>,
    /// Measurements of today (CSV)
    #[arg(long, value_name = "FILE")]
    pub data: Input,
    #[command(flatten)]
    pub grouped: Grouped,
    /// File in which the looks at this robot are kept; the level of a look depends on how many were before [default: this is the first look]
    #[arg(long, value_name = "FILE")]
    pub history: Option<Record>,
    /// Page with all looks at this robot (HTML), for people
    #[arg(long, value_name = "FILE", requires = "history")]
    pub page: Option<Output>,
    /// Folder for the report of this look: `index.html`, its figures, `monitor.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<OutputFolder>,
    /// File with the head of the report, [certificate] (TOML)
    #[arg(long, value_name = "FILE", requires = "report")]
    pub certificate: Option<Input>,
    /// When the robot was measured, e.g. 2026-03-01; it stands in the history and on the pages
    #[arg(long, value_name = "DATE", value_parser = parse_date)]
    pub date: Option<String>,
    /// Specification of the 3-D position error, compared with the measured poses as the fit predicts them, e.g. 0.5mm; exit code 1 when they
    /// fail and the robot has not changed
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = parse_length, conflicts_with_all = ["base", "tool", "targets"])]
    pub spec: Option<f64>,
    /// Probability that an unchanged robot ever raises an alarm, over all looks
    #[arg(long, default_value_t = 0.01)]
    pub alpha: f64,
    /// The instrument was set up anew: find the base from these data
    #[arg(long)]
    pub base: bool,
    /// The tool was mounted anew: find it from these data
    #[arg(long)]
    pub tool: bool,
    /// Targets were mounted anew: find them from these data
    #[arg(long)]
    pub targets: bool,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}
