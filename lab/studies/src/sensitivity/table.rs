//! The table of the study: one row a policy.

use crate::discovery::record::Record;
use crate::prelude::*;

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
pub fn text(rows: &[Row], robots: u64, nulls: u64, multiple: f64) -> Outcome<String> {
    let mut table = Table::columns(&[
        ("policy", -32),
        ("first right", 11),
        ("found", 8),
        ("extras", 7),
        ("alarms", 8),
        ("differ", 7),
    ]);
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
