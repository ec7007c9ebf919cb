//! What the lines come to.

use super::hidden_effects::HiddenEffect;
use super::record::{Interval, Record};
use crate::prelude::*;

/// The p of a null's first screen.
pub fn first_p(record: &Record) -> f64 {
    if record.p_first > 0.0 && record.first != "outlier" { record.p_first } else { record.p_value }
}

fn count(records: &[&Record], is: impl Fn(&Record) -> bool) -> usize {
    records.iter().filter(|record| is(record)).count()
}

/// Records that ended, by hidden cause; causes without any are left out.
fn by_cause(records: &[Record], is: impl Fn(&Record) -> bool) -> Vec<(String, Vec<&Record>)> {
    let of = |cause: &HiddenEffect| {
        let word = cause.word();
        let mine = records.iter().filter(|r| r.cause == word && is(r)).collect();
        (word, mine)
    };
    HiddenEffect::all().iter().map(of).filter(|(_, mine): &(_, Vec<_>)| !mine.is_empty()).collect()
}

/// Nulls.
pub fn nulls(records: &[Record]) -> Outcome<String> {
    let ended: Vec<&Record> = records.iter().filter(|r| r.ended()).collect();
    let alarm = |r: &Record| r.findings > 0 || r.significant;
    let failed = records.len() - ended.len();
    let mut text = format!("Robots with nothing hidden: {} ({failed} ended in an error)\n", records.len());
    let mut table = Table::columns("robot -8|count 6|alarms 7|outliers 9|λ, largest 12|cpu s 10|most 8");
    let mut kinds: Vec<(&str, bool)> = ended.iter().map(|r| (r.robot.as_str(), r.heavy)).collect();
    kinds.sort_unstable();
    kinds.dedup();
    for (robot, heavy) in kinds {
        let here: Vec<&Record> =
            ended.iter().copied().filter(|r| r.robot == robot && r.heavy == heavy).collect();
        let lambda = format!("{:.2e}", largest(here.iter().map(|r| r.lambda)));
        let processor = fixed(upper_median(here.iter().map(|r| r.processor)), 2);
        let most = largest(here.iter().map(|r| r.processor));
        let most = format!("{most:>8.2}{}", if heavy { "   heavy tails" } else { "" });
        let (alarms, outliers) = (count(&here, alarm), count(&here, |r| r.first == "outlier"));
        table.row(&[&robot, &here.len(), &alarms, &outliers, &lambda, &processor, &most]);
    }
    text += &table.text();
    let alarms: Vec<&&Record> = ended.iter().filter(|r| alarm(r)).collect();
    writeln!(text, "false alarms: {} of {} (allowed: 4 of 1000)", alarms.len(), ended.len())?;
    for r in alarms {
        writeln!(text, "  none {} 0: {}, p {}, {}", r.seed, r.robot, r.p_first, r.story)?;
    }
    let p: Vec<f64> = ended.iter().map(|r| first_p(r)).collect();
    if !p.is_empty() {
        let (distance, probability) = uniformity(&p);
        let words = "p of the first screen against the uniform law";
        writeln!(text, "{words}: D = {distance:.3}, p = {probability:.3}")?;
    }
    Ok(text)
}

/// Power by cause and multiple.
pub fn power(records: &[Record], multiples: &[f64]) -> Outcome<String> {
    let heads: String = multiples.iter().map(|multiple| format!("{multiple} 9|")).collect();
    let mut table =
        Table::columns(&format!("hidden -18|{heads}first name 10|listed 8|extras 9|ratio 9|worst 8"));
    for (word, mine) in by_cause(records, Record::ended) {
        let mut cells = vec![word];
        for &m in multiples {
            let here: Vec<&Record> = mine.iter().copied().filter(|r| (r.multiple - m).abs() < 1e-9).collect();
            cells.push(part_of(count(&here, |r| r.found), here.len()));
        }
        // Where it can be seen.
        let clear: Vec<&Record> = mine.iter().copied().filter(|r| r.multiple > 1.9).collect();
        let extras = clear.iter().map(|r| r.extras as f64).sum::<f64>() / clear.len().max(1) as f64;
        cells.extend([
            part_of(count(&clear, |r| r.first_right), clear.len()),
            count(&clear, |r| !r.first_right && r.listed).to_string(),
            fixed(extras, 2),
            fixed(upper_median(clear.iter().map(|r| r.ratio)), 3),
            fixed(largest(clear.iter().map(|r| r.ratio)), 3),
        ]);
        table.cells(&cells);
    }
    let mut text = format!(
        "Found with the right name and place, of those that were tried; multiples of the detectable size\n{}\
         first name, listed (the truth an equivalent alternative of a wrong first find), extras and held-out\n\
         RMS over the true plant's: at 2 and more times the detectable size\n",
        table.text()
    );
    for r in records.iter().filter(|r| !r.ended()) {
        writeln!(text, "  {} {} {}: {} {}", r.cause, r.seed, r.multiple, r.first, r.story)?;
    }
    Ok(text)
}

/// First-named family by hidden cause, at 2 and more times the detectable size.
pub fn confusion(records: &[Record]) -> BTreeMap<(String, String), usize> {
    let mut counts = BTreeMap::new();
    for r in records.iter().filter(|r| r.ended() && r.multiple > 1.9) {
        *counts.entry((r.cause.clone(), r.first.clone())).or_insert(0) += 1;
    }
    counts
}

/// The confusion matrix as a list of what is not zero.
pub fn confusion_text(records: &[Record]) -> Outcome<String> {
    let mut text = String::from("What is named first, at 2 and more times the detectable size\n");
    let counts = confusion(records);
    for word in HiddenEffect::all().iter().map(Word::word) {
        let mine = counts.iter().filter(|((cause, _), _)| *cause == word);
        let mut here: Vec<(&str, usize)> = mine.map(|((_, first), n)| (first.as_str(), *n)).collect();
        here.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
        if !here.is_empty() {
            let list: Vec<String> = here.iter().map(|(family, n)| format!("{family} {n}")).collect();
            writeln!(text, "{word:18} {}", list.join(", "))?;
        }
    }
    Ok(text)
}

/// Intervals that hold the truth, at 4 and more times the detectable size and below.
pub fn coverage(records: &[Record]) -> Outcome<String> {
    let head =
        "95 % intervals that hold the truth (below 4 times the detectable size, selection biases them)\n";
    let mut table = Table::columns("hidden -18|4 and more 12|below 12|without width 14");
    let mut all = Fraction::of([]);
    for (word, mine) in by_cause(records, |r| !r.intervals.is_empty()) {
        let at = |large: bool| -> Vec<&Interval> {
            mine.iter().filter(|r| (r.multiple > 3.9) == large).flat_map(|r| &r.intervals).collect()
        };
        let (clear, small) = (at(true), at(false));
        let held = |list: &[&Interval]| Fraction::of(list.iter().filter(|i| !i.empty()).map(|i| i.covers()));
        let (a, b) = (held(&clear), held(&small));
        all = Fraction { hits: all.hits + a.hits, of: all.of + a.of };
        let empty = clear.iter().chain(&small).filter(|i| i.empty()).count();
        table.row(&[&word, &part_of(a.hits, a.of), &part_of(b.hits, b.of), &empty]);
    }
    let sum = part_of(all.hits, all.of);
    let last = format!("{:18} {sum:>12}  {:.1} % (asked for: 93–97 %)\n", "all", all.percent());
    Ok(head.to_owned() + &table.text() + &last)
}

/// Findings with one family removed from the library.
pub fn without(records: &[Record]) -> Outcome<String> {
    let mut text = String::from("The hidden cause's family taken out of the library\n");
    let wrong = |r: &Record| {
        !["none", "unmodelled", "outlier"].contains(&r.first.as_str()) && !r.listed && r.p_first < 0.01
    };
    for (word, mine) in by_cause(records, Record::ended) {
        let [unmodelled, none] = ["unmodelled", "none"].map(|first| count(&mine, |r| r.first == first));
        let named = mine.iter().filter(|r| wrong(r)).map(|r| format!("{} ({})", r.first, r.seed));
        let mut names: Vec<String> = named.collect();
        names.sort();
        let (listed, number, names) = (count(&mine, |r| r.listed), names.len(), names.join(", "));
        let counts = format!("unmodelled {unmodelled}, nothing {none}, listed {listed}");
        writeln!(text, "{word:18} {counts}, wrong name {number}: {names}")?;
    }
    let ended: Vec<&Record> = records.iter().filter(|r| r.ended()).collect();
    writeln!(text, "wrong names at p < 0.01: {} of {}", count(&ended, wrong), ended.len())?;
    Ok(text)
}
