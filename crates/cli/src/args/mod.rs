//! The command line.

mod acceptance;
mod dwell;
mod files;
mod fitted;
mod grouped;
mod measured;
mod other;
mod program;
mod upkeep;
mod values;

pub use acceptance::{FramesFrom, Iso9283};
pub use dwell::DwellOf;
pub use files::{Files, Input, NamedFile, OutputFolder, Prior};
pub use fitted::{Accept, Compensate, Export, ExportFormat, Map, Plan, PlannedTest, Predict, YamlStyle};
pub use grouped::{Grouped, NamedColumns};
pub use measured::{Compare, Discover, Identify, Measured};
#[cfg(feature = "completions")]
pub use other::CompletionsOf;
pub use other::{Check, Completions, Effects, Init, Simulate, Verify};
pub use upkeep::{Fleet, Monitor, Transfer};

use clap::{Arg, ArgMatches, Command, CommandFactory, FromArgMatches, Parser, Subcommand};
use std::path::Path;
use truepose_io::RobotOptions;
use truepose_workflow::InputFiles;

/// Robot calibration: identifies geometric and elastic errors of a robot arm, finds effects that the model lacks, and compensates
#[derive(Debug, Parser)]
#[command(name = "truepose", version, max_term_width = 100)]
pub struct Args {
    /// Number of threads; results do not depend on it [default: all cores]
    #[arg(long, global = true, display_order = 900, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// End the run after this time and keep the findings so far, e.g. 10min (exit code 3)
    #[arg(long, global = true, display_order = 901, value_name = "TIME", allow_hyphen_values = true, value_parser = values::parse_time)]
    pub time_limit: Option<std::time::Duration>,
    /// End the run when it uses more memory, and keep the findings so far, e.g. 2GB (exit code 3)
    #[arg(long, global = true, display_order = 902, value_name = "SIZE", allow_hyphen_values = true, value_parser = values::parse_memory)]
    pub memory_limit: Option<u64>,
    /// Print results and errors alone: no progress, no warnings
    #[arg(long, short, global = true, display_order = 903)]
    pub quiet: bool,
    /// The verb
    #[command(subcommand)]
    pub verb: Verb,
    /// The files of the verb
    #[arg(skip)]
    pub files: Files,
}

impl Args {
    /// Parses the command line; ends the program where it is not valid.
    pub fn typed() -> Self {
        let command = Args::whole();
        let found = command.clone().get_matches_from(crate::typed::arguments());
        Args::of(&command, &found).unwrap_or_else(|error| error.exit())
    }

    fn of(command: &Command, found: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Args { files: Files::of(command, found), ..Args::from_arg_matches(found)? })
    }

    /// The command line, for completions and the manual page.
    pub fn whole() -> Command {
        negative(Args::command())
    }

    /// Parses arguments that were recorded, the words behind the program's name; with all outputs in a folder of our own where one is given.
    ///
    /// # Errors
    /// What is wrong with them, in one line.
    pub fn recorded(arguments: &[String], into: Option<&Path>) -> Result<Self, String> {
        let words = std::iter::once("truepose").chain(arguments.iter().map(String::as_str));
        let command = Args::whole();
        let command = into.map_or_else(|| command.clone(), |into| files::redirected(command.clone(), into));
        command.clone().try_get_matches_from(words).and_then(|found| Args::of(&command, &found)).map_err(
            |error| {
                let all = error.to_string();
                let first = all.lines().next().unwrap_or("they are not arguments of this program");
                first.strip_prefix("error: ").unwrap_or(first).to_owned()
            },
        )
    }
}

/// Takes numbers below zero as values, so that the message is "too small" and not "no such option".
fn negative(command: Command) -> Command {
    let one = |arg: Arg| if arg.get_action().takes_values() { arg.allow_negative_numbers(true) } else { arg };
    command.mut_args(one).mut_subcommands(negative)
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Fit a declared error model to measured poses, and estimate its accuracy on held-out data
    Identify(Identify),
    /// Find effects that the declared model lacks, add them, and test the enlarged model on held-out data
    Discover(Discover),
    /// Plan further measurements: for accuracy, or to distinguish two hypotheses
    Plan(Plan),
    /// Predict the position of the real robot from a fit
    Predict(Predict),
    /// Compute the joint commands that bring the real robot to desired poses
    Compensate(Box<Compensate>),
    /// Write the fitted geometry as a URDF, a table of axes, a kinematics file, or tables of component errors
    Export(Export),
    /// Map the robot's accuracy over its workspace, before and after compensation
    Map(Map),
    /// Pose accuracy, repeatability and the other figures of ISO 9283 from repeated poses, with their uncertainty
    #[command(name = "iso9283")]
    Iso9283(Iso9283),
    /// Find base (tool, targets) of an identified arm in a new installation, from a few poses
    Transfer(Transfer),
    /// Make a prior for the next robot of a type from the fits of others
    Fleet(Fleet),
    /// Test whether the robot has changed since it was calibrated (exit code 3: it has)
    Monitor(Monitor),
    /// Fit one model with several solver strategies, on the same folds, and test the differences
    Compare(Compare),
    /// Write a robot description from the library of makers' published dimensions, and a table to fill in
    Init(Init),
    /// Find the dwells in a log of a moving robot, and write them as measurements
    Dwell(Box<DwellOf>),
    /// Read files and list what they contain: every unit, range and count
    Check(Check),
    /// List the effects and solvers that can be declared
    Effects(Effects),
    /// Simulate measurements of a robot by a laser tracker, with physical error sources
    Simulate(Simulate),
    /// Repeat a run from the run.json of its report, and compare the results
    Verify(Verify),
    /// Write completions for a shell, or the manual page, to standard output
    #[command(hide = true)]
    Completions(Completions),
}

/// The robot.
#[derive(Debug, clap::Args)]
pub struct Robot {
    /// Robot description (.toml or .urdf)
    #[arg(long, value_name = "FILE")]
    pub robot: Input,
    /// Base link of a URDF [default: its root]
    #[arg(long, value_name = "LINK")]
    pub base: Option<String>,
    /// Tip link of a URDF [default: its only leaf]
    #[arg(long, value_name = "LINK")]
    pub tip: Option<String>,
    /// The measurement frame of the data is the base link of the URDF [default: where an instrument measured, it is found from the data]
    #[arg(long)]
    pub base_known: bool,
    /// The measured point is the tip link of the URDF [default: where an instrument measured, it is found from the data]
    #[arg(long)]
    pub tool_known: bool,
}

impl Robot {
    /// Its file, without measurements.
    pub fn files(&self) -> InputFiles {
        InputFiles {
            robot: self.robot.to_path_buf(),
            links: RobotOptions { base: self.base.clone(), tip: self.tip.clone() },
            known: [self.base_known, self.tool_known],
            ..InputFiles::default()
        }
    }
}
