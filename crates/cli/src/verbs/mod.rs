//! The verbs: each is parse, one library call, print.

pub mod check;
pub mod compare;
pub mod compensate;
pub mod discover;
pub mod effects;
pub mod identify;
pub mod predict;
pub mod simulate;

use crate::args::Robot;
use crate::failure::Failure;
use crate::terminal;
use truepose_io::{RobotOptions, read_robot};
use truepose_kinematics::Chain;

/// Reads a robot and passes on what is suspicious about it.
fn robot(args: &Robot) -> Result<Chain, Failure> {
    let options = RobotOptions { base: args.base.clone(), tip: args.tip.clone() };
    let (chain, warnings) = read_robot(&args.robot, &options)?;
    terminal::warn(&warnings);
    Ok(chain)
}

/// A value as JSON on stdout.
fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    terminal::print(&(serde_json::to_string_pretty(value)? + "\n"));
    Ok(())
}
