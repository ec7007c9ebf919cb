//! What the lines come to.

use super::hidden_effects::HIDDEN_EFFECTS;
use super::record::{Interval, Record};
use std::collections::BTreeMap;
use std::fmt::{Error, Write};

/// Distance of Kolmogorov and Smirnov from the uniform law, and its probability (Stephens' form of the limit).
pub fn uniformity(values: &[f64]) -> (f64, f64) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let distance = sorted
        .iter()
        .enumerate()
        .fold(0.0f64, |most, (k, &p)| most.max((p - k as f64 / n).abs()).max(((k + 1) as f64 / n - p).abs()));
    let x = distance * (n.sqrt() + 0.12 + 0.11 / n.sqrt());
    let terms = (1..=100).map(|k| {
        let k = f64::from(k);
        let sign = if k as u32 % 2 == 1 { 2.0 } else { -2.0 };
        sign * (-2.0 * k * k * x * x).exp()
    });
    let probability = if x < 0.2 { 1.0 } else { terms.sum::<f64>().clamp(0.0, 1.0) };
    (distance, probability)
}

/// The p of a null's first screen.
pub fn first_p(record: &Record) -> f64 {
    if record.p_first > 0.0 && record.first != "outlier" { record.p_first } else { record.p_value }
}

pub fn median(mut values: Vec<f64>) -> f64 {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.filter(|value| value.is_finite()).fold(f64::NAN, f64::max)
}

/// Nulls.
pub fn nulls(records: &[Record]) -> Result<String, Error> {
    let mut text = String::new();
    let ended: Vec<&Record> = records.iter().filter(|r| r.ended()).collect();
    let alarm = |r: &&&Record| r.findings > 0 || r.significant;
    writeln!(
        text,
        "Robots with nothing hidden: {} ({} ended in an error)",
        records.len(),
        records.len() - ended.len()
    )?;
    writeln!(
        text,
        "{:8} {:>6} {:>7} {:>9} {:>12} {:>10} {:>8}",
        "robot", "count", "alarms", "outliers", "λ, largest", "cpu s", "most"
    )?;
    let mut kinds: Vec<(&str, bool)> = ended.iter().map(|r| (r.robot.as_str(), r.heavy)).collect();
    kinds.sort_unstable();
    kinds.dedup();
    for (robot, heavy) in kinds {
        let here: Vec<&Record> =
            ended.iter().copied().filter(|r| r.robot == robot && r.heavy == heavy).collect();
        writeln!(
            text,
            "{:8} {:>6} {:>7} {:>9} {:>12.2e} {:>10.2} {:>8.2}{}",
            robot,
            here.len(),
            here.iter().filter(alarm).count(),
            here.iter().filter(|r| r.first == "outlier").count(),
            largest(here.iter().map(|r| r.lambda)),
            median(here.iter().map(|r| r.processor).collect()),
            largest(here.iter().map(|r| r.processor)),
            if heavy { "   heavy tails" } else { "" }
        )?;
    }
    let alarms: Vec<&&Record> = ended.iter().filter(alarm).collect();
    writeln!(text, "false alarms: {} of {} (allowed: 4 of 1000)", alarms.len(), ended.len())?;
    for r in alarms {
        writeln!(text, "  none {} 0: {}, p {}, {}", r.seed, r.robot, r.p_first, r.story)?;
    }
    let p: Vec<f64> = ended.iter().map(|r| first_p(r)).collect();
    if !p.is_empty() {
        let (distance, probability) = uniformity(&p);
        writeln!(
            text,
            "p of the first screen against the uniform law: D = {distance:.3}, p = {probability:.3}"
        )?;
    }
    Ok(text)
}

/// Power by cause and multiple.
pub fn power(records: &[Record], multiples: &[f64]) -> Result<String, Error> {
    let mut text = String::new();
    writeln!(
        text,
        "Found with the right name and place, of those that were tried; multiples of the detectable size"
    )?;
    write!(text, "{:18}", "hidden")?;
    multiples.iter().try_for_each(|m| write!(text, " {m:>9}"))?;
    writeln!(text, " {:>10} {:>8} {:>9} {:>9} {:>8}", "first name", "listed", "extras", "ratio", "worst")?;
    for (_, word) in HIDDEN_EFFECTS {
        let mine = || records.iter().filter(move |r| r.cause == word && r.ended());
        if mine().next().is_none() {
            continue;
        }
        write!(text, "{word:18}")?;
        for &m in multiples {
            let here: Vec<&Record> = mine().filter(|r| (r.multiple - m).abs() < 1e-9).collect();
            write!(text, " {:>9}", format!("{}/{}", here.iter().filter(|r| r.found).count(), here.len()))?;
        }
        // Where it can be seen.
        let clear: Vec<&Record> = mine().filter(|r| r.multiple > 1.9).collect();
        let all = clear.len();
        writeln!(
            text,
            " {:>10} {:>8} {:>9.2} {:>9.3} {:>8.3}",
            format!("{}/{all}", clear.iter().filter(|r| r.first_right).count()),
            clear.iter().filter(|r| !r.first_right && r.listed).count(),
            clear.iter().map(|r| r.extras as f64).sum::<f64>() / all.max(1) as f64,
            median(clear.iter().map(|r| r.ratio).collect()),
            largest(clear.iter().map(|r| r.ratio)),
        )?;
    }
    writeln!(
        text,
        "first name, listed (the truth an equivalent alternative of a wrong first find), extras and held-out"
    )?;
    writeln!(text, "RMS over the true plant's: at 2 and more times the detectable size")?;
    for r in records.iter().filter(|r| ["error", "panic", "no_plant"].contains(&r.first.as_str())) {
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
pub fn confusion_text(records: &[Record]) -> Result<String, Error> {
    let mut text = String::from("What is named first, at 2 and more times the detectable size\n");
    let counts = confusion(records);
    for (_, word) in HIDDEN_EFFECTS {
        let mut here: Vec<(&str, usize)> = counts
            .iter()
            .filter(|((cause, _), _)| cause == word)
            .map(|((_, f), n)| (f.as_str(), *n))
            .collect();
        here.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
        if !here.is_empty() {
            let list: Vec<String> = here.iter().map(|(family, n)| format!("{family} {n}")).collect();
            writeln!(text, "{word:18} {}", list.join(", "))?;
        }
    }
    Ok(text)
}

/// Intervals that hold the truth, at 4 and more times the detectable size and below.
pub fn coverage(records: &[Record]) -> Result<String, Error> {
    let mut text = String::from(
        "95 % intervals that hold the truth (below 4 times the detectable size, selection biases them)\n",
    );
    writeln!(text, "{:18} {:>12} {:>12} {:>14}", "hidden", "4 and more", "below", "without width")?;
    let (mut inside, mut all) = (0, 0);
    for (_, word) in HIDDEN_EFFECTS {
        let at = |large: bool| -> Vec<&Interval> {
            let mine = records.iter().filter(|r| r.cause == word && (r.multiple > 3.9) == large);
            mine.flat_map(|r| &r.intervals).collect()
        };
        let (clear, small) = (at(true), at(false));
        if clear.is_empty() && small.is_empty() {
            continue;
        }
        let held = |list: &[&Interval]| {
            let wide: Vec<&&Interval> = list.iter().filter(|i| !i.empty()).collect();
            (wide.iter().filter(|i| i.covers()).count(), wide.len())
        };
        let (a, b) = (held(&clear), held(&small));
        (inside, all) = (inside + a.0, all + a.1);
        let empty = clear.iter().chain(&small).filter(|i| i.empty()).count();
        writeln!(
            text,
            "{word:18} {:>12} {:>12} {empty:>14}",
            format!("{}/{}", a.0, a.1),
            format!("{}/{}", b.0, b.1)
        )?;
    }
    let share = 100.0 * inside as f64 / f64::from(all.max(1) as u32);
    writeln!(text, "{:18} {:>12}  {share:.1} % (asked for: 93–97 %)", "all", format!("{inside}/{all}"))?;
    Ok(text)
}

/// Findings with one family removed from the library.
pub fn without(records: &[Record]) -> Result<String, Error> {
    let mut text = String::from("The hidden cause's family taken out of the library\n");
    let ended: Vec<&Record> = records.iter().filter(|r| r.ended()).collect();
    let wrong = |r: &Record| {
        !["none", "unmodelled", "outlier"].contains(&r.first.as_str()) && !r.listed && r.p_first < 0.01
    };
    for (_, word) in HIDDEN_EFFECTS {
        let mine: Vec<&&Record> = ended.iter().filter(|r| r.cause == word).collect();
        if mine.is_empty() {
            continue;
        }
        let of = |first: &str| mine.iter().filter(|r| r.first == first).count();
        let mut names: Vec<String> =
            mine.iter().filter(|r| wrong(r)).map(|r| format!("{} ({})", r.first, r.seed)).collect();
        names.sort();
        writeln!(
            text,
            "{word:18} unmodelled {}, nothing {}, listed {}, wrong name {}: {}",
            of("unmodelled"),
            of("none"),
            mine.iter().filter(|r| r.listed).count(),
            names.len(),
            names.join(", ")
        )?;
    }
    let count = ended.iter().filter(|r| wrong(r)).count();
    writeln!(text, "wrong names at p < 0.01: {count} of {}", ended.len())?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_values_are_uniform_and_small_ones_are_not() {
        let even: Vec<f64> = (0..200).map(|k| (f64::from(k) + 0.5) / 200.0).collect();
        assert!(uniformity(&even).1 > 0.99);
        let small: Vec<f64> = even.iter().map(|p| p * p).collect();
        assert!(uniformity(&small).1 < 1e-6);
    }
}
