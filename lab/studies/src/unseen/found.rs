//! Tables of what is found and how it is named.

use super::cause::{INSIDE, OUTSIDE, WORDS};
use super::description::Kind;
use super::interval::{Fraction, brier, calibration};
use super::record::Record;
use super::select::{fraction, numbers, of, quantiles};
use std::fmt::{Error, Write};

pub fn power(records: &[&Record]) -> Result<String, Error> {
    let here = of(records, Kind::Power);
    let mut text = String::new();
    if here.is_empty() {
        return Ok(text);
    }
    let row = |text: &mut String, name: &str, mine: &[&Record]| {
        let any = Fraction::of(mine.iter().map(|r| r.number("findings") > Some(0.0)));
        let column = |column: &str| fraction(mine.iter().copied(), column);
        writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {any} |",
            mine.len(),
            column("found"),
            column("first_right"),
            column("listed")
        )
    };
    writeln!(
        text,
        "| cause at 5 × the noise, poses | robots | found | named first | first or listed | any finding |"
    )?;
    writeln!(text, "| --- | --- | --- | --- | --- | --- |")?;
    for cell in Kind::Power.cells() {
        let mine: Vec<&Record> = here.iter().copied().filter(|r| r.text("cell") == cell).collect();
        if !mine.is_empty() {
            row(&mut text, &cell, &mine)?;
        }
    }
    writeln!(
        text,
        "\n| cause at 5 × the noise, 30 poses or more | robots | found | named first | first or listed | any finding |"
    )?;
    writeln!(text, "| --- | --- | --- | --- | --- | --- |")?;
    for cause in INSIDE {
        let mine: Vec<&Record> = here
            .iter()
            .copied()
            .filter(|r| r.text("cause") == cause.word() && r.number("poses") >= Some(30.0))
            .collect();
        if !mine.is_empty() {
            row(&mut text, cause.word(), &mine)?;
        }
    }
    Ok(text)
}

pub fn unweighed(records: &[&Record]) -> Result<String, Error> {
    let here = of(records, Kind::Unweighed);
    let mut text = String::new();
    if here.is_empty() {
        return Ok(text);
    }
    writeln!(
        text,
        "| weights not declared, cause at 5 × the noise, 30 to 100 poses | robots | any finding | named first | first or listed | confidently wrong |"
    )?;
    writeln!(text, "| --- | --- | --- | --- | --- | --- |")?;
    for cell in Kind::Unweighed.cells() {
        let mine: Vec<&Record> = here.iter().copied().filter(|r| r.text("cell") == cell).collect();
        if mine.is_empty() {
            continue;
        }
        let column = |column: &str| fraction(mine.iter().copied(), column);
        writeln!(
            text,
            "| {cell} | {} | {} | {} | {} | {} |",
            mine.len(),
            Fraction::of(mine.iter().map(|r| r.number("findings") > Some(0.0))),
            column("first_right"),
            column("listed"),
            column("confident_wrong")
        )?;
    }
    Ok(text)
}

pub fn words(records: &[&Record]) -> Result<String, Error> {
    let here = of(records, Kind::Words);
    let mut text = String::new();
    if here.is_empty() {
        return Ok(text);
    }
    writeln!(
        text,
        "| row of the vocabulary, 5 × the noise, 130 poses | robots | any finding | named first | named first or listed | held-out error over that with the right effect declared: median (10–90 %) | over that without the cause |"
    )?;
    writeln!(text, "| --- | --- | --- | --- | --- | --- | --- |")?;
    for cause in WORDS {
        let mine: Vec<&Record> = here
            .iter()
            .copied()
            .filter(|r| r.text("cause") == cause.word() && r.text("ended") == "yes")
            .collect();
        if mine.is_empty() {
            continue;
        }
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} |",
            cause.word(),
            mine.len(),
            Fraction::of(mine.iter().map(|r| r.number("findings") > Some(0.0))),
            fraction(mine.iter().copied(), "first_right"),
            fraction(mine.iter().copied(), "listed"),
            quantiles(numbers(&mine, "oracle_ratio")),
            quantiles(numbers(&mine, "held_ratio"))
        )?;
    }
    Ok(text)
}

pub fn everything(records: &[&Record]) -> Result<String, Error> {
    let here = of(records, Kind::Everything);
    let mut text = String::new();
    if here.is_empty() {
        return Ok(text);
    }
    writeln!(
        text,
        "| everything at once, poses | robots | a cause that is there first | the two largest named | findings | error of fresh rows over the noise: before, | after | the true robot, commanded by the model, over the noise |"
    )?;
    writeln!(text, "| --- | --- | --- | --- | --- | --- | --- | --- |")?;
    for cell in Kind::Everything.cells() {
        let mine: Vec<&Record> = here.iter().copied().filter(|r| r.text("cell") == cell).collect();
        if mine.is_empty() {
            continue;
        }
        let fresh = mine.iter().filter_map(|r| {
            let (error, noise) = (r.number("fresh_mm")?, r.number("floor_mm")?);
            Some(error.hypot(noise) / noise)
        });
        writeln!(
            text,
            "| {cell} | {} | {} | {} | {} | {} | {} | {} |",
            mine.len(),
            fraction(mine.iter().copied(), "first_right"),
            fraction(mine.iter().copied(), "found"),
            quantiles(numbers(&mine, "findings")),
            quantiles(numbers(&mine, "executed_before")),
            quantiles(fresh.collect()),
            quantiles(numbers(&mine, "executed"))
        )?;
    }
    Ok(text)
}

pub fn outside(records: &[&Record]) -> Result<String, Error> {
    let here = of(records, Kind::Outside);
    let mut text = String::new();
    if here.is_empty() {
        return Ok(text);
    }
    writeln!(
        text,
        "| cause without a word, 2–10 × the noise | robots | any finding | a right place first | verdict not adequate, or a finding | fresh error over that with nothing hidden |"
    )?;
    writeln!(text, "| --- | --- | --- | --- | --- | --- |")?;
    for cause in OUTSIDE {
        let mine: Vec<&Record> = here.iter().copied().filter(|r| r.text("cause") == cause.word()).collect();
        if mine.is_empty() {
            continue;
        }
        let found = |r: &&Record| r.number("findings") > Some(0.0);
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} |",
            cause.word(),
            mine.len(),
            Fraction::of(mine.iter().map(found)),
            fraction(mine.iter().copied(), "first_right"),
            Fraction::of(mine.iter().map(|r| r.text("verdict") != "adequate" || found(r))),
            quantiles(numbers(&mine, "fresh_ratio"))
        )?;
    }
    Ok(text)
}

pub fn alarms(records: &[&Record]) -> Result<String, Error> {
    let mut text = String::new();
    let kinds = [Kind::Null, Kind::Memory, Kind::Flicker, Kind::Columns, Kind::Joints, Kind::Stated];
    for kind in kinds {
        let here = of(records, kind);
        for cell in kind.cells() {
            let mine: Vec<&Record> = here.iter().copied().filter(|r| r.text("cell") == cell).collect();
            if mine.is_empty() {
                continue;
            }
            if text.is_empty() {
                writeln!(
                    text,
                    "| nothing hidden | robots | false alarms | a name among them | rows called outliers | autocorrelation reported |"
                )?;
                writeln!(text, "| --- | --- | --- | --- | --- | --- |")?;
            }
            let named = |r: &&Record| !["none", "unmodelled"].contains(&r.text("first"));
            writeln!(
                text,
                "| {} {cell} | {} | {} | {} | {} | {} |",
                kind.word(),
                mine.len(),
                fraction(mine.iter().copied(), "alarm"),
                mine.iter().filter(|r| named(r)).count(),
                Fraction::of(mine.iter().map(|r| r.number("outliers") > Some(0.0))),
                quantiles(numbers(&mine, "autocorrelation"))
            )?;
        }
    }
    Ok(text)
}

/// Probabilities that were given, and whether they came true.
fn events(records: &[&Record]) -> Vec<(f64, bool)> {
    let one = |text: &str| {
        let (probability, hit) = text.split_once(':')?;
        Some((probability.parse().ok()?, hit == "1"))
    };
    records.iter().flat_map(|r| r.text("names").split('|').filter_map(one).collect::<Vec<_>>()).collect()
}

pub fn names(records: &[&Record]) -> Result<String, Error> {
    let mut text = String::new();
    let side = |inside: bool| -> Vec<&Record> {
        records.iter().copied().filter(|r| r.yes("inside") == Some(inside)).collect()
    };
    let (inside, outside) = (side(true), side(false));
    if inside.len() + outside.len() == 0 {
        return Ok(text);
    }
    // A version that reports no probabilities is never confident.
    let reported = !events(records).is_empty();
    writeln!(text, "| names | robots | Brier score | confidently wrong (above 0.9, the truth not listed) |")?;
    writeln!(text, "| --- | --- | --- | --- |")?;
    for (name, mine) in [("inside the vocabulary", &inside), ("without a word", &outside)] {
        let score = brier(&events(mine)).map_or("–".into(), |score| format!("{score:.3}"));
        let counted = mine.iter().copied().filter(|_| reported);
        let wrong = fraction(counted, "confident_wrong");
        writeln!(text, "| {name} | {} | {score} | {wrong} |", mine.len())?;
    }
    let every: Vec<(f64, bool)> = events(&inside).into_iter().chain(events(&outside)).collect();
    if !every.is_empty() {
        writeln!(text, "\n| probability reported | mean | came true |\n| --- | --- | --- |")?;
        let edges = [0.0, 0.05, 0.2, 0.5, 0.8, 0.95, 1.0];
        for (pair, (mean, hits)) in edges.windows(2).zip(calibration(&every, &edges)) {
            writeln!(text, "| {} to {} | {mean:.2} | {hits} |", pair[0], pair[1])?;
        }
    }
    Ok(text)
}
