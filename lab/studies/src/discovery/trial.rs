//! One robot through the loop, and what became of it.
//!
//! Robots with two or three causes at once: do they hide each other?

use super::hidden_effects::{HiddenEffect, word_of};
use super::plants::{HOLDOUT, Made, Several, make, several};
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
        let (begun, spent) = (Instant::now(), processor_seconds());
        let looked = caught(|| self.look(&made, policy));
        record.seconds = begun.elapsed().as_secs_f64();
        record.processor = processor_seconds() - spent;
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
        Record {
            cause: word_of(self.cause),
            multiple: self.multiple,
            seed: self.seed,
            first: "none".into(),
            ..Record::default()
        }
    }

    fn describe(&self, made: &Made, record: &mut Record) {
        record.robot.clone_from(&made.robot);
        record.heavy = made.heavy;
        record.visits = made.seen.data.visit.iter().max().map_or(0, |last| last + 1);
        record.lambda = made.lambda;
    }

    fn judge(&self, made: &Made, diagnosis: &Diagnosis, record: &mut Record) {
        let findings = &diagnosis.findings;
        let right = |family: Family, place: &Place| match (self.cause, &made.hidden) {
            (Some(cause), Some(hidden)) => is_named(cause, family) && is_there(&hidden.place, place),
            _ => false,
        };
        let hit = |finding: &Finding| right(finding.candidate.family, &finding.candidate.place);
        record.p_value = diagnosis.unexplained.p_value;
        record.significant = diagnosis.unexplained.significant;
        if let Some(first) = findings.first() {
            record.first = first.candidate.family.word().into();
            record.first_right = hit(first);
            record.listed = first.alternatives.iter().any(|a| {
                let unnamed = self.without && a.family == Family::Unmodelled;
                a.equivalent && (unnamed || right(a.family, &a.place))
            });
            record.p_first = first.p_value;
        }
        record.found = findings.iter().any(hit);
        record.findings = findings.len();
        record.extras = findings.iter().filter(|finding| !hit(finding)).count();
        (record.ratio, record.ratio_before) = ratios(made, diagnosis);
        if let (Some(cause), Some(found)) = (self.cause, findings.iter().find(|finding| hit(finding))) {
            record.intervals = intervals(cause, made, found);
        }
        let words: Vec<String> = findings.iter().map(|finding| finding.candidate.words()).collect();
        let truth = made.hidden.as_ref().map_or(String::new(), |hidden| hidden.place.words());
        record.story = plain(&format!("truth {truth}: {}", words.join("; ")));
    }
}

/// Held-out RMS over that of the true plant, after and before.
pub(super) fn ratios(made: &Made, diagnosis: &Diagnosis) -> (f64, f64) {
    let noise = noise_of(&made.seen, &diagnosis.holdout_rows);
    let over = |errors: &Errors| errors.holdout.positions().rms / noise;
    (over(&diagnosis.after), over(&diagnosis.before))
}

/// Whether the family is a right word for a cause.
pub(super) fn is_named(cause: HiddenEffect, family: Family) -> bool {
    family == cause.family()
}

/// Whether a place agrees with the truth in all keys of the truth.
pub(super) fn is_there(truth: &Place, place: &Place) -> bool {
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
    let blank =
        Record { cause: WORD.into(), multiple: MULTIPLE, seed, first: "none".into(), ..Record::default() };
    match judged_several(seed, blank.clone()) {
        Ok(record) => record,
        Err(error) => Record { first: "error".into(), story: plain(&error.to_string()), ..blank },
    }
}

fn judged_several(seed: u64, mut record: Record) -> Outcome<Record> {
    let Several { made, causes: hidden } = several(MULTIPLE, seed)?;
    let options = DiscoverOptions { holdout: Some(HOLDOUT.0), seed: HOLDOUT.1, ..DiscoverOptions::default() };
    let begun = Instant::now();
    let data = &made.seen.data;
    let diagnosis = diagnose(&made.chain, &made.declared, data, &PivotedQr::default(), &options, &|_| ())?;
    record.seconds = begun.elapsed().as_secs_f64();
    record.robot.clone_from(&made.robot);
    record.visits = data.visit.iter().max().map_or(0, |last| last + 1);
    let names = |finding: &Finding, k: usize| {
        let (cause, hidden) = &hidden[k];
        is_named(*cause, finding.candidate.family) && is_there(&hidden.place, &finding.candidate.place)
    };
    let of_any = |finding: &&Finding| (0..hidden.len()).any(|k| names(finding, k));
    let named =
        (0..hidden.len()).filter(|&k| diagnosis.findings.iter().any(|finding| names(finding, k))).count();
    record.found = named == hidden.len();
    record.findings = diagnosis.findings.len();
    record.extras = diagnosis.findings.iter().filter(|finding| !of_any(finding)).count();
    if let Some(first) = diagnosis.findings.first() {
        record.first = first.candidate.family.word().into();
        record.first_right = of_any(&first);
        record.p_first = first.p_value;
    }
    (record.p_value, record.significant) = (diagnosis.unexplained.p_value, diagnosis.unexplained.significant);
    (record.ratio, record.ratio_before) = ratios(&made, &diagnosis);
    let truth: Vec<String> =
        hidden.iter().map(|(cause, hidden)| format!("{} {}", cause.word(), hidden.place.words())).collect();
    let words: Vec<String> = diagnosis.findings.iter().map(|finding| finding.candidate.words()).collect();
    record.story =
        plain(&format!("{named} of {} truth {}: {}", hidden.len(), truth.join("; "), words.join("; ")));
    Ok(record)
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
    let mut ratios: Vec<f64> = ended.iter().map(|record| record.ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let quantile = |share: f64| ratios.get((share * (ratios.len().max(1) - 1) as f64) as usize).copied();
    let [middle, most, worst] = [0.5, 0.9, 1.0].map(|share| quantile(share).unwrap_or(f64::NAN));
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
