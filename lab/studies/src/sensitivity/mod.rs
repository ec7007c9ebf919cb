//! What one half and twice a belief of `discover` change: robots of the power study and nulls, under each policy.
//!
//! `study sensitivity [--robots N] [--nulls N] [--multiple M] [--beliefs B,B] [--factors F,F] [--folder NAME]` runs what is not yet in its
//! tables. Robot k has the k-th cause of the power study (in turn) at `M` times the detectable size, and seed k; all policies see the same
//! robots. Beliefs are those of [`truepose_discover::Policy`]; without `--beliefs` all of them.

use crate::prelude::*;
mod table;

use crate::discovery::hidden_effects::HiddenEffect;
use crate::discovery::record::Record;
use crate::discovery::trial::Task;
use truepose_discover::Policy;

/// What was asked for.
#[derive(Parser)]
struct Asked {
    #[arg(long, default_value_t = 20)]
    robots: u64,
    #[arg(long, default_value_t = 20)]
    nulls: u64,
    #[arg(long, default_value_t = 2.0)]
    multiple: f64,
    #[arg(long, value_delimiter = ',')]
    beliefs: Vec<String>,
    #[arg(long, value_delimiter = ',', default_values_t = [0.5, 2.0])]
    factors: Vec<f64>,
    #[command(flatten)]
    kept: Kept,
}

/// A policy with one belief changed; no belief for the default.
struct Changed {
    belief: String,
    factor: f64,
    policy: Policy,
}

/// Runs the study.
pub fn run(arguments: &[String]) -> Outcome {
    let mut asked: Asked = asked(arguments)?;
    if asked.beliefs.is_empty() {
        asked.beliefs = Policy::default().table().into_iter().map(|(belief, _)| belief.to_owned()).collect();
    }
    let (folder, commit) = asked.kept.open("sensitivity")?;
    let tasks = asked.tasks();
    let mut rows = Vec::new();
    for Changed { belief, factor, policy } in asked.policies()? {
        let part = if belief.is_empty() { "default".into() } else { format!("{belief}_x{factor}") };
        let mut journal: Journal<Record> = Journal::open(&folder, &part, &commit)?;
        let words = |task: &&Task, record: &Record| {
            Some(format!("{part}, {}: {} in {:.1} s", task.words(), record.first, record.seconds))
        };
        journal.complete(
            &tasks,
            |known, task| task.is_of(known),
            |task| Ok(task.run_under(&policy)),
            words,
        )?;
        let of_this = |record: &Record| tasks.iter().any(|task| task.is_of(record));
        rows.push(table::Row::of(&part, journal.records.into_iter().filter(of_this).collect()));
    }
    let text =
        format!("commit {commit}\n\n{}", table::text(&rows, asked.robots, asked.nulls, asked.multiple)?);
    finish("sensitivity", &folder.join("table.txt"), &text)
}

impl Asked {
    /// Robots with one hidden cause each, and nulls.
    fn tasks(&self) -> Vec<Task> {
        let hidden = (0..self.robots).map(|seed| Task {
            cause: Some(HiddenEffect::all()[seed as usize % HiddenEffect::all().len()]),
            multiple: self.multiple,
            seed,
            without: false,
        });
        let nulls = (0..self.nulls).map(|seed| Task { cause: None, multiple: 0.0, seed, without: false });
        hidden.chain(nulls).collect()
    }

    /// The default policy, and each belief times each factor.
    fn policies(&self) -> Outcome<Vec<Changed>> {
        let default = Policy::default();
        let mut all = vec![Changed { belief: String::new(), factor: 1.0, policy: default.clone() }];
        for belief in &self.beliefs {
            for &factor in self.factors.iter().filter(|&&factor| (factor - 1.0).abs() > 1e-9) {
                let policy = default.scaled(belief, factor);
                let policy = policy.ok_or_else(|| format!("`{belief}` is no belief of the policy"))?;
                all.push(Changed { belief: belief.clone(), factor, policy });
            }
        }
        Ok(all)
    }
}
