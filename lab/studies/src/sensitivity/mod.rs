//! What one half and twice a belief of `discover` change: robots of the power study and nulls, under each policy.
//!
//! `study sensitivity [--robots N] [--nulls N] [--multiple M] [--beliefs B,B] [--factors F,F] [--folder NAME]` runs what is not yet in its
//! tables. Robot k has the k-th cause of the power study (in turn) at `M` times the detectable size, and seed k; all policies see the same
//! robots. Beliefs are those of [`truepose_discover::Policy`]; without `--beliefs` all of them.
//!
//! The table of the study: one row a policy.

use crate::discovery::hidden_effects::HiddenEffect;
use crate::discovery::record::Record;
use crate::discovery::trial::Task;
use crate::prelude::*;
use truepose_discover::Policy;

/// The options of the run.
#[derive(Parser)]
struct Options {
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
    let mut options: Options = parsed(arguments)?;
    if options.beliefs.is_empty() {
        options.beliefs =
            Policy::default().table().into_iter().map(|(belief, _)| belief.to_owned()).collect();
    }
    let (folder, commit) = options.kept.open("sensitivity")?;
    let tasks = options.tasks();
    let mut rows = Vec::new();
    for Changed { belief, factor, policy } in options.policies()? {
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
        rows.push(Row::of(&part, journal.records.into_iter().filter(of_this).collect()));
    }
    let text =
        format!("commit {commit}\n\n{}", table_text(&rows, options.robots, options.nulls, options.multiple)?);
    finish("sensitivity", &folder.join("table.txt"), &text)
}

impl Options {
    /// Robots with one hidden cause each, and nulls.
    fn tasks(&self) -> Vec<Task> {
        let of = |seed: u64| HiddenEffect::all()[seed as usize % HiddenEffect::all().len()];
        let hidden = (0..self.robots).map(|seed| Task::of(of(seed), self.multiple, seed));
        hidden.chain((0..self.nulls).map(Task::null)).collect()
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

/// What a policy came to.
pub struct Row {
    policy: String,
    /// Robots whose first finding has the right name and place; that have it at all.
    first_right: usize,
    found: usize,
    /// Findings that are not the hidden cause.
    extras: usize,
    /// Nulls with a finding, or with a residual that is called significant.
    alarms: usize,
    /// Robots and nulls that ended.
    ended: [usize; 2],
    /// What each robot came to, to count differences from the default.
    outcomes: Vec<String>,
}

impl Row {
    /// Of the lines of one policy, robots first.
    pub fn of(policy: &str, records: Vec<Record>) -> Self {
        let (hidden, nulls): (Vec<&Record>, Vec<&Record>) =
            records.iter().filter(|record| record.ended()).partition(|record| record.cause != "none");
        let outcome = |r: &Record| format!("{} {} {}: {}", r.cause, r.seed, r.first_right, r.story);
        Row {
            policy: policy.to_owned(),
            first_right: hidden.iter().filter(|record| record.first_right).count(),
            found: hidden.iter().filter(|record| record.found).count(),
            extras: hidden.iter().map(|record| record.extras).sum(),
            alarms: nulls.iter().filter(|record| record.findings > 0 || record.significant).count(),
            ended: [hidden.len(), nulls.len()],
            outcomes: hidden.iter().chain(&nulls).map(|record| outcome(record)).collect(),
        }
    }

    /// How many robots and nulls end with other findings than under another policy.
    fn differing(&self, other: &Row) -> usize {
        self.outcomes.iter().filter(|outcome| !other.outcomes.contains(outcome)).count()
    }
}

/// The table; the first row is the default policy.
fn table_text(rows: &[Row], robots: u64, nulls: u64, multiple: f64) -> Outcome<String> {
    let mut table = Table::columns("policy -32|first right 11|found 8|extras 7|alarms 8|differ 7");
    for row in rows {
        let of = |count: usize, part: usize| part_of(count, row.ended[part]);
        let (first, found, alarms) = (of(row.first_right, 0), of(row.found, 0), of(row.alarms, 1));
        let differing = rows.first().map_or(0, |default| row.differing(default));
        table.row(&[&row.policy, &first, &found, &row.extras, &alarms, &differing]);
    }
    Ok(format!(
        "{robots} robots with one hidden cause at {multiple} times the detectable size, {nulls} nulls\n{}\
         differ: robots and nulls that end with other findings than under the default policy\n",
        table.text()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(cause: &str, first: &str, findings: usize) -> Record {
        let right = cause == first && cause != "none";
        Record {
            cause: cause.into(),
            first: first.into(),
            first_right: right,
            found: right,
            findings,
            extras: findings - usize::from(right),
            story: first.into(),
            ..Record::default()
        }
    }

    #[test]
    fn findings_in_a_null_are_an_alarm_and_other_stories_differ() {
        let default = Row::of("default", vec![record("drift", "drift", 1), record("none", "none", 0)]);
        let loose = Row::of("loose", vec![record("drift", "shift", 2), record("none", "shift", 1)]);
        assert_eq!((default.first_right, default.extras, default.alarms), (1, 0, 0));
        assert_eq!((loose.first_right, loose.extras, loose.alarms), (0, 2, 1));
        assert_eq!((default.ended, default.differing(&default), loose.differing(&default)), ([1, 1], 0, 2));
    }
}
