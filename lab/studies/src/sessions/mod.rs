//! Sessions, transfer, monitoring and fleets: what is said of them, measured on simulated robots.
//!
//! `study sessions [PART…] [--robots N] [--half tuning|locked]`; parts: `alarms`, `slips`, `installed`, `transfer`, `fleet`. Robots of the
//! locked half have the odd seeds: nothing is tuned to them.

use crate::prelude::*;
mod alarms;
mod installed;
mod robots;
mod sisters;
mod slips;
mod transferred;

use crate::parts;

/// The parts, with the number of robots of each.
const PARTS: [(&str, u64); 5] =
    [("alarms", 1000), ("slips", 300), ("installed", 150), ("transfer", 150), ("fleet", 60)];

/// Runs the study.
pub fn run(arguments: &[String]) -> Outcome {
    parts::run("sessions", &PARTS, arguments, |part, scope| match part {
        "alarms" => alarms::table(scope),
        "slips" => slips::table(scope),
        "installed" => installed::table(scope),
        "transfer" => transferred::table(scope),
        _ => sisters::table(scope),
    })
}
