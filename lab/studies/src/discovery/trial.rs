//! One robot through the loop, and what became of it.
//!
//! Robots with two or three causes at once: do they hide each other?

use super::hidden_effects::{Hidden, HiddenEffect, word_of};
use super::plants::{HOLDOUT, Made, make, several};
use super::record::{Record, intervals};
use crate::prelude::*;
use truepose_discover::{
    Diagnosis, DiscoverOptions, Errors, Family, Finding, Library, Place, Policy, diagnose,
};

/// A robot to come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Task {
    /// None is a null.
    pub cause: Option<HiddenEffect>,
    pub multiple: f64,
    pub seed: u64,
    /// The cause's family is taken out of the library.
    pub without: bool,
}

impl Task {
    /// A robot with one hidden cause, all of the library.
    pub fn of(cause: HiddenEffect, multiple: f64, seed: u64) -> Self {
        Task { cause: Some(cause), multiple, ..Task::null(seed) }
    }

    /// A robot with nothing hidden.
    pub fn null(seed: u64) -> Self {
        Task { cause: None, multiple: 0.0, seed, without: false }
    }

    /// What to type for it alone.
    pub fn words(&self) -> String {
        let cause = word_of(self.cause);
        let without = if self.without { " --without" } else { "" };
        format!("{cause} {} {}{without}", self.seed, self.multiple)
    }

    /// The plant and the results of the search.
    pub fn diagnosed(&self) -> Outcome<(Made, Diagnosis)> {
        let made = make(self.cause, self.multiple, self.seed)?;
        let diagnosis = self.look(&made, &Policy::default())?;
        Ok((made, diagnosis))
    }

    fn look(&self, made: &Made, policy: &Policy) -> Outcome<Diagnosis> {
        let options = DiscoverOptions {
            holdout: Some(HOLDOUT.0),
            seed: HOLDOUT.1,
            library: match self.cause.filter(|_| self.without) {
                Some(cause) => Library::standard().without(cause.family()),
                None => Library::standard(),
            },
            policy: policy.clone(),
            ..DiscoverOptions::default()
        };
        let data = &made.seen.data;
        Ok(diagnose(&made.chain, &made.declared, data, &PivotedQr::default(), &options, &|_| ())?)
    }

    /// One line of the table. What the loop refuses, and where it panics, is a result as well.
    pub fn run(&self) -> Record {
        self.run_under(&Policy::default())
    }

    /// The same under other beliefs.
    pub fn run_under(&self, policy: &Policy) -> Record {
        let mut record = self.blank();
        let made = match make(self.cause, self.multiple, self.seed) {
            Ok(made) => made,
            Err(error) => {
                record.first = "no_plant".into();
                record.story = plain(&error.to_string());
                return record;
            }
        };
        self.describe(&made, &mut record);
        let (begun, spent) = (Instant::now(), process());
        let looked = caught(|| self.look(&made, policy));
        record.seconds = begun.elapsed().as_secs_f64();
        record.processor = process() - spent;
        match looked {
            Ok(diagnosis) => self.judge(&made, &diagnosis, &mut record),
            Err(words) if words == "panic" => record.first = words,
            Err(words) => (record.first, record.story) = ("error".into(), plain(&words)),
        }
        record
    }

    /// Whether a line is that of this robot.
    pub fn is_of(&self, record: &Record) -> bool {
        record.is(&word_of(self.cause), self.multiple, self.seed)
    }

    /// The line of a diagnosis.
    pub fn judged(&self, made: &Made, diagnosis: &Diagnosis) -> Record {
        let mut record = self.blank();
        self.describe(made, &mut record);
        self.judge(made, diagnosis, &mut record);
        record
    }

    fn blank(&self) -> Record {
        blank(word_of(self.cause), self.multiple, self.seed)
    }

    fn describe(&self, made: &Made, record: &mut Record) {
        record.robot.clone_from(&made.robot);
        record.heavy = made.heavy;
        record.visits = visits(made);
        record.lambda = made.lambda;
    }

    fn judge(&self, made: &Made, diagnosis: &Diagnosis, record: &mut Record) {
        compare(made, diagnosis, record);
        let findings = &diagnosis.findings;
        record.listed = findings.first().is_some_and(|first| {
            first.alternatives.iter().any(|a| {
                let unnamed = self.without && a.family == Family::Unmodelled;
                a.equivalent && (unnamed || made.hidden.iter().any(|of| is_named(of, a.family, &a.place)))
            })
        });
        for hidden in &made.hidden {
            if let Some(found) = findings.iter().find(|finding| is_found(hidden, finding)) {
                record.intervals = intervals(hidden.0, made, found);
            }
        }
        let truth = made.hidden.first().map_or(String::new(), |(_, hidden)| hidden.place.words());
        record.story = plain(&format!("truth {truth}: {}", words(findings)));
    }
}

fn blank(cause: String, multiple: f64, seed: u64) -> Record {
    Record { cause, multiple, seed, first: "none".into(), ..Record::default() }
}

/// Notes what was found of what is hidden, and how well unseen rows are predicted; how many of the causes have their name and place.
fn compare(made: &Made, diagnosis: &Diagnosis, record: &mut Record) -> usize {
    let (hidden, findings) = (&made.hidden, &diagnosis.findings);
    let right = |finding: &Finding| hidden.iter().any(|of| is_found(of, finding));
    let named = hidden.iter().filter(|of| findings.iter().any(|finding| is_found(of, finding))).count();
    record.found = named > 0 && named == hidden.len();
    record.findings = findings.len();
    record.extras = findings.iter().filter(|finding| !right(finding)).count();
    if let Some(first) = findings.first() {
        record.first = first.candidate.family.word().into();
        (record.first_right, record.p_first) = (right(first), first.p_value);
    }
    (record.p_value, record.significant) = (diagnosis.unexplained.p_value, diagnosis.unexplained.significant);
    let noise = noise_of(&made.seen, &diagnosis.holdout_rows);
    let over = |errors: &Errors| errors.holdout.positions().rms / noise;
    (record.ratio, record.ratio_before) = (over(&diagnosis.after), over(&diagnosis.before));
    named
}

fn words(findings: &[Finding]) -> String {
    findings.iter().map(|finding| finding.candidate.words()).collect::<Vec<_>>().join("; ")
}

/// Whether a name and a place are right for a cause.
fn is_named((cause, hidden): &(HiddenEffect, Hidden), family: Family, place: &Place) -> bool {
    family == cause.family() && is_there(&hidden.place, place)
}

fn is_found(hidden: &(HiddenEffect, Hidden), finding: &Finding) -> bool {
    is_named(hidden, finding.candidate.family, &finding.candidate.place)
}

/// Whether a place agrees with the truth in all keys of the truth.
fn is_there(truth: &Place, place: &Place) -> bool {
    let agrees = |truth: &Option<String>, place: &Option<String>| truth.is_none() || truth == place;
    let level = match (truth.level, place.level) {
        (Some(a), Some(b)) => (a - b).abs() < 1e-6,
        (Some(_), None) => false,
        (None, _) => true,
    };
    agrees(&truth.joint, &place.joint)
        && agrees(&truth.driver, &place.driver)
        && agrees(&truth.channel, &place.channel)
        && agrees(&truth.target, &place.target)
        && level
}

/// Each cause is this many times as large as it would have to be alone to be detected.
pub const MULTIPLE: f64 = 8.0;
/// Text of the records in place of an effect.
const WORD: &str = "several";

/// Runs what is not yet in the table.
pub fn work_several(journal: &mut Journal<Record>, robots: u64) -> Outcome {
    let words = |seed: &u64, record: &Record| {
        Some(format!("{WORD} {seed}: {}, ratio {:.2}", record.story, record.ratio))
    };
    journal.complete(
        0..robots,
        |known, seed| known.is(WORD, MULTIPLE, *seed),
        |seed| Ok(run_several(*seed)),
        words,
    )
}

/// One robot: `found` when every effect was found with its name and place; `extras` counts other findings.
fn run_several(seed: u64) -> Record {
    let blank = blank(WORD.into(), MULTIPLE, seed);
    let failed =
        |error: Failure| Record { first: "error".into(), story: plain(&error.to_string()), ..blank.clone() };
    judged_several(seed, blank.clone()).unwrap_or_else(failed)
}

fn judged_several(seed: u64, mut record: Record) -> Outcome<Record> {
    let made = several(MULTIPLE, seed)?;
    let begun = Instant::now();
    let diagnosis = Task::null(seed).look(&made, &Policy::default())?;
    record.seconds = begun.elapsed().as_secs_f64();
    record.robot.clone_from(&made.robot);
    record.visits = visits(&made);
    let named = compare(&made, &diagnosis, &mut record);
    let truth =
        made.hidden.iter().map(|(cause, hidden)| format!("{} {}", cause.word(), hidden.place.words()));
    let (count, truth) = (made.hidden.len(), truth.collect::<Vec<_>>().join("; "));
    record.story = plain(&format!("{named} of {count} truth {truth}: {}", words(&diagnosis.findings)));
    Ok(record)
}

fn visits(made: &Made) -> usize {
    made.seen.data.visit.iter().max().map_or(0, |last| last + 1)
}

/// What the lines come to.
pub fn summary_of_several(records: &[Record]) -> Result<String, std::fmt::Error> {
    let ended: Vec<&Record> = records.iter().filter(|record| record.ended()).collect();
    let count = |of: fn(&Record) -> bool| ended.iter().filter(|record| of(record)).count();
    let counts = |record: &&&Record| -> Option<(usize, usize)> {
        let (named, rest) = record.story.split_once(" of ")?;
        Some((named.parse().ok()?, rest.split_whitespace().next()?.parse().ok()?))
    };
    let (named, hidden) =
        ended.iter().filter_map(|r| counts(&r)).fold((0, 0), |sum, (a, b)| (sum.0 + a, sum.1 + b));
    let ratios = || ended.iter().map(|record| record.ratio);
    let [middle, most, worst] = [0.5, 0.9, 1.0].map(|share| nearest_quantile(ratios(), share));
    let (all, first) = (count(|record| record.found), count(|record| record.first_right));
    let (robots, nothing) = (ended.len(), count(|record| record.findings == 0));
    let extras: usize = ended.iter().map(|record| record.extras).sum();
    Ok(format!(
        "Two or three causes in one robot, each {MULTIPLE} times as large as is detectable alone\n\
         {robots} robots: causes with the right name and place {named} of {hidden}, all of a robot's {all}, first find right {first}, nothing found {nothing}\n\
         further finds {extras}; held-out RMS over the true plant's: median {middle:.3}, of nine in ten {most:.3}, worst {worst:.3}\n"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_has_to_agree_in_all_that_the_truth_says() {
        let truth = Place { joint: Some("a3".into()), driver: Some("a2".into()), ..Place::default() };
        let more = Place { component: Some("rz".into()), ..truth.clone() };
        assert!(is_there(&truth, &truth) && is_there(&truth, &more));
        assert!(!is_there(&truth, &Place { joint: Some("a3".into()), ..Place::default() }));
        let level = |kg| Place { level: Some(kg), ..Place::default() };
        assert!(is_there(&level(5.0), &level(5.0)) && !is_there(&level(5.0), &level(9.0)));
        assert!(is_there(&Place::default(), &truth));
    }
}
