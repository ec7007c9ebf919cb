//! Tables of the repeatability limit, verdicts, intervals, bad poses, predictions and p-values.

use super::description::{KINDS, Kind};
use super::interval::Fraction;
use super::record::Record;
use super::select::{fraction, numbers, of, quantiles};
use crate::discovery::summary::{median, uniformity};
use std::fmt::{Error, Write};

/// A reported repeatability limit within these multiples of the truth is right.
const NEAR: [f64; 2] = [0.8, 1.25];
/// Poses that are measured twice, from which on their scatter is known to a sixth.
const MANY: f64 = 8.0;
/// Something is left above the first, nothing below the second: systematic error at fresh poses over the noise of a row.
const LEFT: [f64; 2] = [1.0, 0.5];

pub fn limits(records: &[&Record]) -> Result<String, Error> {
    let mut text = String::new();
    // A campaign with stated deviations that are wrong is a case of its own; an estimate from few repeats scatters.
    let group = |r: &Record| {
        let source = match r.text("floor_source") {
            "" => "not reported",
            "repeats" if r.number("repeats") < Some(MANY) => "repeats, fewer than 8 poses twice",
            "repeats" => "repeats, 8 poses or more twice",
            source => source,
        };
        let wrong = r.text("kind") == Kind::Stated.word();
        format!("{source}{}", if wrong { ", stated wrongly" } else { "" })
    };
    let mut groups: Vec<String> = records.iter().map(|record| group(record)).collect();
    groups.sort_unstable();
    groups.dedup();
    writeln!(
        text,
        "| repeatability limit, source | robots | within 0.8–1.25 of the truth | reported over true: median (10–90 %) | interval contains the truth |"
    )?;
    writeln!(text, "| --- | --- | --- | --- | --- |")?;
    for name in groups {
        let mine: Vec<&Record> = records.iter().copied().filter(|record| group(record) == name).collect();
        let ratios = numbers(&mine, "floor_ratio");
        let near = ratios.iter().map(|ratio| (NEAR[0]..=NEAR[1]).contains(ratio));
        writeln!(
            text,
            "| {name} | {} | {} | {} | {} |",
            mine.len(),
            Fraction::of(near),
            quantiles(ratios.clone()),
            fraction(mine.iter().copied(), "floor_covered")
        )?;
    }
    Ok(text)
}

pub fn verdicts(records: &[&Record]) -> Result<String, Error> {
    let mut text = String::new();
    let judged: Vec<&Record> =
        records.iter().copied().filter(|r| r.number("left").is_some() && r.text("kind") != "bad").collect();
    if judged.is_empty() {
        return Ok(text);
    }
    writeln!(text, "| truth | robots | adequate | undecided | unexplained | not reported | as required |")?;
    writeln!(text, "| --- | --- | --- | --- | --- | --- | --- |")?;
    let something: Vec<&Record> =
        judged.iter().copied().filter(|r| r.number("left") > Some(LEFT[0])).collect();
    let nothing: Vec<&Record> = judged.iter().copied().filter(|r| r.number("left") < Some(LEFT[1])).collect();
    for (name, mine, right) in [
        ("something is left (more than the noise)", something, ["unexplained", "undecided"]),
        ("nothing is left (less than half of it)", nothing, ["adequate", "undecided"]),
    ] {
        let count = |word: &str| mine.iter().filter(|r| r.text("verdict") == word).count();
        let reported = mine.iter().filter(|r| !r.text("verdict").is_empty());
        writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {} | {} |",
            mine.len(),
            count("adequate"),
            count("undecided"),
            count("unexplained"),
            count(""),
            Fraction::of(reported.map(|r| right.contains(&r.text("verdict"))))
        )?;
    }
    Ok(text)
}

pub fn intervals(records: &[&Record]) -> Result<String, Error> {
    let mut text = String::new();
    writeln!(text, "| 95 % interval of | contains the truth |\n| --- | --- |")?;
    for (name, column) in [
        ("the held-out error before", "before_covered"),
        ("the held-out error after", "after_covered"),
        ("the gain", "gain_covered"),
    ] {
        writeln!(text, "| {name} | {} |", fraction(records.iter().copied(), column))?;
    }
    Ok(text)
}

pub fn bad(records: &[&Record]) -> Result<String, Error> {
    let here = of(records, Kind::Bad);
    let mut text = String::new();
    if here.is_empty() {
        return Ok(text);
    }
    writeln!(
        text,
        "| bad poses of 100 | robots | least displaced, in deviations of a row | all reported | all reported or called suspect | some row of each reported | limit within 10 % of that without | error within 10 % of that without | error over that without |"
    )?;
    writeln!(text, "| --- | --- | --- | --- | --- | --- | --- | --- | --- |")?;
    for cell in Kind::Bad.cells() {
        let mine: Vec<&Record> = here.iter().copied().filter(|r| r.text("cell") == cell).collect();
        if mine.is_empty() {
            continue;
        }
        let whole = |column: &str| Fraction::of(mine.iter().map(|r| r.number(column) >= r.number("bad")));
        let near = |column: &str| {
            let values = numbers(&mine, column);
            Fraction::of(values.iter().map(|ratio| (ratio - 1.0).abs() < 0.1))
        };
        writeln!(
            text,
            "| {cell} | {} | {} | {} | {} | {} | {} | {} | {} |",
            mine.len(),
            quantiles(numbers(&mine, "bad_least")),
            whole("bad_reported"),
            whole("bad_known"),
            whole("bad_partly"),
            near("bad_floor_ratio"),
            near("bad_fresh_ratio"),
            quantiles(numbers(&mine, "bad_fresh_ratio"))
        )?;
    }
    Ok(text)
}

pub fn harm(records: &[&Record]) -> Result<String, Error> {
    let mut text = String::new();
    writeln!(
        text,
        "| predictions | robots | worse than the declared model by more than 5 % | held-out RMS over its noise | fresh error over that with nothing hidden, after | before |"
    )?;
    writeln!(text, "| --- | --- | --- | --- | --- | --- |")?;
    for kind in KINDS {
        let mine = of(records, kind);
        if mine.is_empty() {
            continue;
        }
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} |",
            kind.word(),
            mine.len(),
            fraction(mine.iter().copied(), "harm"),
            quantiles(numbers(&mine, "ratio")),
            quantiles(numbers(&mine, "fresh_ratio")),
            quantiles(numbers(&mine, "declared_ratio"))
        )?;
    }
    Ok(text)
}

pub fn screen(records: &[&Record]) -> Result<String, Error> {
    let mut text = String::new();
    let p = numbers(&of(records, Kind::Null), "p_first");
    if p.is_empty() {
        return Ok(text);
    }
    let (distance, probability) = uniformity(&p);
    writeln!(
        text,
        "| p of the first screen, nothing hidden | robots | distance from uniform | probability of a larger one | below 0.05 | median |"
    )?;
    writeln!(text, "| --- | --- | --- | --- | --- | --- |")?;
    writeln!(
        text,
        "| null | {} | {distance:.3} | {probability:.2} | {} | {:.2} |",
        p.len(),
        Fraction::of(p.iter().map(|p| *p < 0.05)),
        median(p.clone())
    )?;
    Ok(text)
}
