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

use crate::journal::commit;
use crate::{folder, print};
use rayon::prelude::*;
use std::error::Error;
use std::fmt::Write;
use std::ops::Range;

/// The parts, with the number of robots of each.
const PARTS: [(&str, u64); 5] =
    [("alarms", 1000), ("slips", 300), ("installed", 150), ("transfer", 150), ("fleet", 60)];

/// What is asked of a part.
struct Asked {
    robots: Range<u64>,
    locked: bool,
}

/// Runs the study.
pub fn run(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let (mut parts, mut robots, mut locked) = (Vec::new(), None, false);
    let mut rest = arguments.iter();
    while let Some(word) = rest.next() {
        match word.as_str() {
            "--robots" => robots = Some(rest.next().ok_or("--robots lacks its number")?.parse::<u64>()?),
            "--half" => {
                locked = match rest.next().map(String::as_str) {
                    Some("tuning") => false,
                    Some("locked") => true,
                    _ => return Err("--half: tuning or locked".into()),
                }
            }
            word => {
                let known = PARTS.iter().find(|(name, _)| *name == word);
                parts.push(*known.ok_or_else(|| format!("unknown part or option `{word}`"))?);
            }
        }
    }
    if parts.is_empty() {
        parts = PARTS.to_vec();
    }
    let half = if locked { "locked" } else { "tuning" };
    for (part, count) in parts {
        let asked = Asked { robots: 0..robots.unwrap_or(count), locked };
        let table = match part {
            "alarms" => alarms::table(&asked)?,
            "slips" => slips::table(&asked)?,
            "installed" => installed::table(&asked)?,
            "transfer" => transferred::table(&asked)?,
            _ => sisters::table(&asked)?,
        };
        let mut text = String::new();
        writeln!(text, "{part}, {half} half, {} robots, commit {}\n{table}", asked.robots.end, commit())?;
        print(&text);
        std::fs::write(folder("sessions")?.join(format!("{part}.{half}.txt")), text)?;
    }
    Ok(())
}

impl Asked {
    /// One record a robot.
    fn each<T: Send>(
        &self,
        one: impl Fn(u64) -> Result<T, Box<dyn Error>> + Sync,
    ) -> Result<Vec<T>, Box<dyn Error>> {
        let told = |number: u64| one(number).map_err(|error| format!("robot {number}: {error}"));
        Ok(self.robots.clone().into_par_iter().map(told).collect::<Result<Vec<T>, String>>()?)
    }
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
