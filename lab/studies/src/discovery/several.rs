//! Robots with two or three causes at once: do they hide each other?

use super::plants::{HOLDOUT, Several, several};
use super::record::Record;
use super::trial::{is_named, is_there, ratios};
use crate::prelude::*;
use truepose_discover::{DiscoverOptions, Finding, diagnose};

/// Each cause is this many times as large as it would have to be alone to be detected.
pub const MULTIPLE: f64 = 8.0;
/// Text of the records in place of an effect.
const WORD: &str = "several";

/// Runs what is not yet in the table.
pub fn work(journal: &mut Journal<Record>, robots: u64) -> Outcome {
    let words = |seed: &u64, record: &Record| {
        Some(format!("{WORD} {seed}: {}, ratio {:.2}", record.story, record.ratio))
    };
    journal.complete(0..robots, |known, seed| known.is(WORD, MULTIPLE, *seed), |seed| Ok(run(*seed)), words)
}

/// One robot: `found` when every effect was found with its name and place; `extras` counts other findings.
fn run(seed: u64) -> Record {
    let blank =
        Record { cause: WORD.into(), multiple: MULTIPLE, seed, first: "none".into(), ..Record::default() };
    match judged(seed, blank.clone()) {
        Ok(record) => record,
        Err(error) => Record { first: "error".into(), story: plain(&error.to_string()), ..blank },
    }
}

fn judged(seed: u64, mut record: Record) -> Outcome<Record> {
    let Several { made, causes: hidden } = several(MULTIPLE, seed)?;
    let options = DiscoverOptions { holdout: Some(HOLDOUT.0), seed: HOLDOUT.1, ..DiscoverOptions::default() };
    let begun = Instant::now();
    let data = &made.seen.data;
    let told = diagnose(&made.chain, &made.declared, data, &PivotedQr::default(), &options, &|_| ())?;
    record.seconds = begun.elapsed().as_secs_f64();
    record.robot.clone_from(&made.robot);
    record.visits = data.visit.iter().max().map_or(0, |last| last + 1);
    let tells = |finding: &Finding, k: usize| {
        let (cause, hidden) = &hidden[k];
        is_named(*cause, finding.candidate.family) && is_there(&hidden.place, &finding.candidate.place)
    };
    let of_any = |finding: &&Finding| (0..hidden.len()).any(|k| tells(finding, k));
    let named = (0..hidden.len()).filter(|&k| told.findings.iter().any(|finding| tells(finding, k))).count();
    record.found = named == hidden.len();
    record.findings = told.findings.len();
    record.extras = told.findings.iter().filter(|finding| !of_any(finding)).count();
    if let Some(first) = told.findings.first() {
        record.first = first.candidate.family.word().into();
        record.first_right = of_any(&first);
        record.p_first = first.p_value;
    }
    (record.p_value, record.significant) = (told.unexplained.p_value, told.unexplained.significant);
    (record.ratio, record.ratio_before) = ratios(&made, &told);
    let truth: Vec<String> =
        hidden.iter().map(|(cause, hidden)| format!("{} {}", cause.word(), hidden.place.words())).collect();
    let words: Vec<String> = told.findings.iter().map(|finding| finding.candidate.words()).collect();
    record.story =
        plain(&format!("{named} of {} truth {}: {}", hidden.len(), truth.join("; "), words.join("; ")));
    Ok(record)
}

/// What the lines come to.
pub fn summary(records: &[Record]) -> Result<String, std::fmt::Error> {
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
