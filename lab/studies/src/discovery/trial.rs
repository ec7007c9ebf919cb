//! One robot through the loop, and what became of it.

use super::coverage;
use super::hidden_effects::HiddenEffect;
use super::plants::{HOLDOUT, Made, make};
use super::record::Record;
use std::error::Error;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;
use truepose_discover::{Diagnosis, DiscoverOptions, Family, Finding, Library, Place, Policy, diagnose};
use truepose_solvers::PivotedQr;

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
        let cause = self.cause.map_or("none", HiddenEffect::word);
        let without = if self.without { " --without" } else { "" };
        format!("{cause} {} {}{without}", self.seed, self.multiple)
    }

    /// The plant and the results of the search.
    pub fn diagnosed(&self) -> Result<(Made, Diagnosis), Box<dyn Error>> {
        let made = make(self.cause, self.multiple, self.seed)?;
        let diagnosis = self.look(&made, &Policy::default())?;
        Ok((made, diagnosis))
    }

    fn look(&self, made: &Made, policy: &Policy) -> Result<Diagnosis, Box<dyn Error>> {
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
        let looked =
            catch_unwind(AssertUnwindSafe(|| self.look(&made, policy).map_err(|error| error.to_string())));
        record.seconds = begun.elapsed().as_secs_f64();
        record.processor = processor_seconds() - spent;
        match looked {
            Err(_) => record.first = "panic".into(),
            Ok(Err(error)) => (record.first, record.story) = ("error".into(), plain(&error)),
            Ok(Ok(diagnosis)) => self.judge(&made, &diagnosis, &mut record),
        }
        record
    }

    /// Whether a line is that of this robot.
    pub fn is_of(&self, record: &Record) -> bool {
        record.is(self.cause.map_or("none", HiddenEffect::word), self.multiple, self.seed)
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
            cause: self.cause.map_or("none", HiddenEffect::word).into(),
            multiple: self.multiple,
            seed: self.seed,
            first: "none".into(),
            ..Record::default()
        }
    }

    fn describe(&self, made: &Made, record: &mut Record) {
        record.robot = made.robot.into();
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
            record.intervals = coverage::intervals(cause, made, found);
        }
        let words: Vec<String> = findings.iter().map(|finding| finding.candidate.words()).collect();
        let truth = made.hidden.as_ref().map_or(String::new(), |hidden| hidden.place.words());
        record.story = plain(&format!("truth {truth}: {}", words.join("; ")));
    }
}

/// Held-out RMS over that of the true plant, after and before.
pub(super) fn ratios(made: &Made, diagnosis: &Diagnosis) -> (f64, f64) {
    let rows = &diagnosis.holdout_rows;
    let square =
        |&row: &usize| (made.seen.data.measured_position(row) - made.seen.true_positions[row]).norm_squared();
    let noise = (rows.iter().map(square).sum::<f64>() / rows.len().max(1) as f64).sqrt();
    let over = |errors: &truepose_discover::Errors| errors.holdout.positions().rms / noise;
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

/// What this process has taken of the processors, s; NaN where the system does not report it as Linux does.
pub fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = text.rsplit(')').next().unwrap_or_default();
    // Hundredths, in user and in system mode.
    let ticks: Vec<f64> =
        after_name.split_whitespace().skip(11).take(2).filter_map(|word| word.parse().ok()).collect();
    if ticks.len() == 2 { 0.01 * ticks.iter().sum::<f64>() } else { f64::NAN }
}

/// Without what would break a row of CSV.
pub(super) fn plain(text: &str) -> String {
    text.replace([',', '\n', '"'], " ")
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
