//! Sessions, transfer, monitoring and fleets: what is said of them, measured on simulated robots.
//!
//! `study sessions [PART…] [--robots N] [--half tuning|locked]`; parts: `alarms`, `slips`, `installed`, `transfer`, `fleet`. Robots of the
//! locked half have the odd seeds: nothing is tuned to them.

mod alarms;
mod installed;
mod robots;
mod sisters;
mod slips;
mod transferred;

use crate::parts;
use std::error::Error;

/// The parts, with the number of robots of each.
const PARTS: [(&str, u64); 5] =
    [("alarms", 1000), ("slips", 300), ("installed", 150), ("transfer", 150), ("fleet", 60)];

/// Runs the study.
pub fn run(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    parts::run("sessions", &PARTS, arguments, |part, asked| match part {
        "alarms" => alarms::table(asked),
        "slips" => slips::table(asked),
        "installed" => installed::table(asked),
        "transfer" => transferred::table(asked),
        _ => sisters::table(asked),
    })
}

/// Root mean square.
fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for value in values {
        sum += value * value;
        count += 1;
    }
    (sum / f64::from(count.max(1))).sqrt()
}

/// The value below which this part of them lies.
fn quantile(mut values: Vec<f64>, part: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let at = (part * (values.len().max(1) - 1) as f64).round() as usize;
    values.get(at).copied().unwrap_or(f64::NAN)
}
