//! Every solver strategy on the same problems: a generated family of which everything is known, and simulated robots.
//!
//! One thing is varied at a time around κ = 1e3, noise 1 %, 600 rows, nothing wrong and every effect real.

use crate::prelude::*;
mod family;
mod optimality;
mod record;
mod robots;
mod summary;
mod trial;

use family::Recipe;
use record::{Record, Solved};

/// Draws of each problem.
const SEEDS: u64 = 3;

const USUAL: Recipe = Recipe { condition: 1e3, noise: 1e-2, outliers: 0.0, rows: 600, effects: 8, seed: 0 };

/// A problem to come: of the family, or the calibration of a robot.
enum Task {
    Family { sweep: &'static str, recipe: Recipe },
    Robot { plant: &'static str, outliers: f64, seed: u64 },
}

impl Task {
    fn name(&self) -> String {
        match self {
            Task::Family { sweep, recipe } => format!("{sweep} {recipe:?}"),
            Task::Robot { plant, outliers, seed } => format!("{plant} {outliers} {seed}"),
        }
    }
}

/// Runs the study.
pub fn run(_: &[String]) -> Outcome {
    let folder = folder("solvers")?;
    let strategies = optimality::strategies()?;
    let mut journal: Journal<Solved> = Journal::open_at(&folder, "partial", &fingerprint()?)?;
    let tasks = tasks();
    let run = |task: &&Task| {
        let records = match task {
            Task::Family { sweep, recipe } => trial::trial(sweep, recipe, &strategies)?,
            Task::Robot { plant, outliers, seed } => robots::trial(plant, *outliers, *seed, &strategies)?,
        };
        Ok(Solved { problem: task.name(), records })
    };
    let words = |task: &&Task, _: &Solved| Some(task.name());
    journal.complete(&tasks, |known, task| known.problem == task.name(), run, words)?;
    let of = |task: &Task| journal.records.iter().find(|known| known.problem == task.name());
    let records: Vec<Record> = tasks.iter().filter_map(of).flat_map(|known| known.records.clone()).collect();
    let text = summary::text(&records, &strategies)?;
    journal.finish("table")?;
    finish("solvers", &folder.join("table.txt"), &text)
}

/// Another program (a changed one) takes nothing up.
fn fingerprint() -> Outcome<String> {
    let program = std::fs::metadata(std::env::current_exe()?)?;
    let time = program.modified()?.duration_since(std::time::UNIX_EPOCH)?;
    Ok(format!("{} {}", program.len(), time.as_nanos()))
}

/// All problems, the order of which is that of the table.
fn tasks() -> Vec<Task> {
    let mut tasks = Vec::new();
    let mut sweep = |sweep: &'static str, seeds: u64, recipe: Recipe| {
        tasks.extend((1..=seeds).map(|seed| Task::Family { sweep, recipe: Recipe { seed, ..recipe } }));
    };
    for power in [1, 2, 4, 6, 8, 10, 12, 14] {
        sweep("condition", SEEDS, Recipe { condition: 10f64.powi(power), ..USUAL });
    }
    for noise in [1e-4, 1e-3, 1e-2, 1e-1, 1.0] {
        sweep("noise", SEEDS, Recipe { noise, ..USUAL });
    }
    for outliers in [0.0, 0.05, 0.10] {
        sweep("outliers", 2 * SEEDS, Recipe { outliers, ..USUAL });
    }
    for rows in [60, 200, 600, 2_000] {
        sweep("rows", SEEDS, Recipe { rows, ..USUAL });
    }
    for rows in [6_000, 20_000] {
        sweep("rows", 1, Recipe { rows, ..USUAL });
    }
    for noise in [1e-2, 1e-1] {
        sweep("sparse", SEEDS, Recipe { noise, effects: 2, ..USUAL });
    }
    for plant in robots::PLANTS {
        for outliers in [0.0, 0.05, 0.10] {
            tasks.extend((1..=2).map(|seed| Task::Robot { plant, outliers, seed }));
        }
    }
    tasks
}
