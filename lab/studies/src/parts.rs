//! Studies of several parts on numbered robots: `study NAME [PART…] [--robots N] [--half tuning|locked]`.

use crate::journal::commit;
use crate::{folder, print};
use rayon::prelude::*;
use std::error::Error;
use std::fmt::Write;

/// What is asked of a part.
pub struct Asked {
    robots: u64,
    /// Whether the robots are those to which nothing is tuned.
    pub locked: bool,
}

impl Asked {
    /// One record a robot, of its number.
    pub fn each<T: Send>(
        &self,
        one: impl Fn(u64) -> Result<T, Box<dyn Error>> + Sync,
    ) -> Result<Vec<T>, Box<dyn Error>> {
        let told = |number: u64| one(number).map_err(|error| format!("robot {number}: {error}"));
        Ok((0..self.robots).into_par_iter().map(told).collect::<Result<Vec<T>, String>>()?)
    }
}

/// Runs the parts that were asked for, all of them where none is named, of `parts` with the number of robots of each. The table of each is
/// printed and stands in the study's folder.
pub fn run(
    study: &str,
    parts: &[(&'static str, u64)],
    arguments: &[String],
    table: impl Fn(&str, &Asked) -> Result<String, Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    let (mut wanted, mut robots, mut locked) = (Vec::new(), None, false);
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
                let known = parts.iter().find(|(name, _)| *name == word);
                wanted.push(*known.ok_or_else(|| format!("unknown part or option `{word}`"))?);
            }
        }
    }
    if wanted.is_empty() {
        wanted = parts.to_vec();
    }
    let half = if locked { "locked" } else { "tuning" };
    for (part, count) in wanted {
        let asked = Asked { robots: robots.unwrap_or(count), locked };
        let table = table(part, &asked)?;
        let mut text = String::new();
        writeln!(text, "{part}, {half} half, {} robots, commit {}\n{table}", asked.robots, commit())?;
        print(&text);
        std::fs::write(folder(study)?.join(format!("{part}.{half}.txt")), text)?;
    }
    Ok(())
}
