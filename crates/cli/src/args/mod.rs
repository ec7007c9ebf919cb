//! What can be typed.

mod beside;
mod from_data;
mod from_fit;
mod grouped;
mod values;

pub use beside::{Check, Effects, Simulate, Verify};
pub use from_data::{Compare, Discover, Identify, Measured, SplitKind};
pub use from_fit::{Compensate, Export, ExportFormat, Map, Plan, Predict};
pub use grouped::Grouped;

use clap::{Arg, Command, CommandFactory, FromArgMatches, Parser, Subcommand};
use std::path::PathBuf;

/// Finds out why a robot arm does not go where it is told, and makes it go there.
#[derive(Debug, Parser)]
#[command(name = "truepose", version, max_term_width = 100)]
pub struct Args {
    /// Threads to use; results do not depend on it [default: all cores]
    #[arg(long, global = true, display_order = 900, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// End after so long, with what was found so far, e.g. 10min (exit code 3)
    #[arg(long, global = true, display_order = 901, value_name = "TIME", allow_hyphen_values = true, value_parser = values::parse_time)]
    pub time_limit: Option<std::time::Duration>,
    /// End when more memory is in use, with what was found so far, e.g. 2GB (exit code 3)
    #[arg(long, global = true, display_order = 902, value_name = "SIZE", allow_hyphen_values = true, value_parser = values::parse_memory)]
    pub memory_limit: Option<u64>,
    /// What to do
    #[command(subcommand)]
    pub verb: Verb,
}

impl Args {
    /// What was typed; ends the program where that makes no sense.
    pub fn typed() -> Self {
        let command = negative(Args::command());
        Args::from_arg_matches(&command.get_matches()).unwrap_or_else(|error| error.exit())
    }
}

/// A number below zero is a value, so that what is said is that it is too small, not that there is no such option.
fn negative(command: Command) -> Command {
    let one = |arg: Arg| if arg.get_action().takes_values() { arg.allow_negative_numbers(true) } else { arg };
    command.mut_args(one).mut_subcommands(negative)
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
