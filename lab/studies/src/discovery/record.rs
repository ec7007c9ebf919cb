//! One line a robot.

use crate::journal::Line;

/// A parameter with its interval and its truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Interval {
    pub name: String,
    pub truth: f64,
    pub value: f64,
    pub ci95: [f64; 2],
}

impl Interval {
    pub fn covers(&self) -> bool {
        (self.ci95[0]..=self.ci95[1]).contains(&self.truth)
    }

    /// An interval without a width has no information.
    pub fn empty(&self) -> bool {
        self.ci95[1] - self.ci95[0] <= 1e-12 * self.value.abs()
    }
}

/// What became of one robot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Record {
    pub cause: String,
    pub multiple: f64,
    pub seed: u64,
    pub robot: String,
    /// Heavy-tailed noise.
    pub heavy: bool,
    pub visits: usize,
    pub lambda: f64,
    /// The first finding's family; `none`, `error`, `panic`, `no_plant`.
    pub first: String,
    /// The first finding has the right name and place.
    pub first_right: bool,
    /// Some finding has.
    pub found: bool,
    pub findings: usize,
    /// Findings that are not the hidden cause.
    pub extras: usize,
    /// The right one (or, with its family taken out, `unmodelled`) is an equivalent alternative of the first.
    pub listed: bool,
    /// Family-wise p of the first finding; of the last screen.
    pub p_first: f64,
    pub p_value: f64,
    pub significant: bool,
    /// Held-out RMS over that of the true plant, after and before.
    pub ratio: f64,
    pub ratio_before: f64,
    /// On the wall, and of the processor where the system reports it.
    pub seconds: f64,
    pub processor: f64,
    pub intervals: Vec<Interval>,
    pub story: String,
}

/// The columns.
const HEADER: &str = "cause,multiple,seed,robot,heavy,visits,lambda,first,first_right,found,findings,extras,listed,\
p_first,p_value,significant,ratio,ratio_before,seconds,processor,intervals,story";

impl Line for Record {
    const HEADER: &'static str = HEADER;

    fn row(&self) -> String {
        let intervals: Vec<String> = self
            .intervals
            .iter()
            .map(|i| format!("{}|{}|{}|{}|{}", i.name, i.truth, i.value, i.ci95[0], i.ci95[1]))
            .collect();
        [
            self.cause.clone(),
            self.multiple.to_string(),
            self.seed.to_string(),
            self.robot.clone(),
            self.heavy.to_string(),
            self.visits.to_string(),
            self.lambda.to_string(),
            self.first.clone(),
            self.first_right.to_string(),
            self.found.to_string(),
            self.findings.to_string(),
            self.extras.to_string(),
            self.listed.to_string(),
            self.p_first.to_string(),
            self.p_value.to_string(),
            self.significant.to_string(),
            self.ratio.to_string(),
            self.ratio_before.to_string(),
            self.seconds.to_string(),
            self.processor.to_string(),
            intervals.join(";"),
            self.story.clone(),
        ]
        .join(",")
    }

    fn of(row: &str) -> Option<Self> {
        let cells: Vec<&str> = row.split(',').collect();
        if cells.len() != HEADER.split(',').count() {
            return None;
        }
        let number = |k: usize| cells[k].parse::<f64>().ok();
        let yes = |k: usize| cells[k].parse::<bool>().ok();
        let count = |k: usize| cells[k].parse::<usize>().ok();
        let interval = |text: &str| {
            let parts: Vec<&str> = text.split('|').collect();
            let [name, numbers @ ..] = &parts[..] else { return None };
            let numbers: Vec<f64> = numbers.iter().filter_map(|cell| cell.parse().ok()).collect();
            let [truth, value, low, high] = numbers[..] else { return None };
            Some(Interval { name: (*name).into(), truth, value, ci95: [low, high] })
        };
        Some(Record {
            cause: cells[0].into(),
            multiple: number(1)?,
            seed: cells[2].parse().ok()?,
            robot: cells[3].into(),
            heavy: yes(4)?,
            visits: count(5)?,
            lambda: number(6)?,
            first: cells[7].into(),
            first_right: yes(8)?,
            found: yes(9)?,
            findings: count(10)?,
            extras: count(11)?,
            listed: yes(12)?,
            p_first: number(13)?,
            p_value: number(14)?,
            significant: yes(15)?,
            ratio: number(16)?,
            ratio_before: number(17)?,
            seconds: number(18)?,
            processor: number(19)?,
            intervals: cells[20].split(';').filter_map(interval).collect(),
            story: cells[21].into(),
        })
    }
}

impl Record {
    /// Whether this is what became of that task.
    pub fn is(&self, cause: &str, multiple: f64, seed: u64) -> bool {
        self.cause == cause && (self.multiple - multiple).abs() < 1e-9 && self.seed == seed
    }

    /// Whether a plant was made and the loop came to an end.
    pub fn ended(&self) -> bool {
        !["error", "panic", "no_plant"].contains(&self.first.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::journal::Journal;
    use std::fs;
    use std::io::Write as _;

    #[test]
    fn a_run_is_taken_up_where_it_was_cut_off() {
        let folder = std::env::temp_dir().join(format!("truepose-discovery-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let interval = Interval { name: "gap a1".into(), truth: 1e-4, value: 1.1e-4, ci95: [0.9e-4, 1.3e-4] };
        assert!(interval.covers() && !interval.empty());
        let record = Record {
            cause: "shift".into(),
            multiple: 2.0,
            seed: 3,
            first: "drift".into(),
            ratio: 0.1 + 0.2,
            intervals: vec![interval],
            ..Record::default()
        };
        let mut journal: Journal<Record> = Journal::open(&folder, "power", "abc").expect("a journal");
        journal.add(record.clone()).expect("a line");
        let path = folder.join("power.csv");
        let half: String = record.row().chars().take(20).collect();
        let mut file = fs::OpenOptions::new().append(true).open(&path).expect("the file");
        write!(file, "{half}").expect("half a line");
        let mut again: Journal<Record> = Journal::open(&folder, "power", "abc").expect("a journal");
        assert_eq!(again.records, std::slice::from_ref(&record));
        assert!(again.records[0].is("shift", 2.0, 3) && !again.records[0].is("shift", 2.0, 4));
        again.add(Record { seed: 4, ..record }).expect("a line");
        let twice: Journal<Record> = Journal::open(&folder, "power", "abc").expect("a journal");
        assert_eq!(twice.records.len(), 2);
        fs::remove_dir_all(&folder).expect("no folder");
    }
}
