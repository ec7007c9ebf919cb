//! Tables: how often each verb did harm, where, and what took long.

use super::record::{Figure, Record};
use super::robots::locked;
use std::fmt::{Error, Write};

/// How much worse than the simplest alternative a result may be on the truth.
pub const BOUND: f64 = 1.05;
/// How much worse than the declared model the whole loop may be in nested folds.
pub const NESTED_BOUND: f64 = 1.02;

/// A figure and its reference.
pub struct Verb {
    pub word: &'static str,
    figure: Figure,
    nominal: Option<Figure>,
    constants: Option<Figure>,
}

impl Verb {
    const fn of(word: &'static str, figure: Figure) -> Self {
        Verb { word, figure, nominal: Some(Figure::Nominal), constants: Some(Figure::Constants) }
    }
}

pub const VERBS: [Verb; 9] = [
    Verb { constants: None, ..Verb::of("identify", Figure::Constants) },
    Verb::of("identify tukey(qr)", Figure::Tukey),
    Verb::of("identify huber(qr)", Figure::Huber),
    Verb::of("identify ridge(map)", Figure::Ridge),
    Verb::of("discover", Figure::Discover),
    Verb::of("export", Figure::Export),
    Verb::of("export as written", Figure::Written),
    Verb {
        word: "compensate (identify)",
        figure: Figure::DriveConstants,
        nominal: Some(Figure::DriveNominal),
        constants: None,
    },
    Verb {
        word: "compensate (discover)",
        figure: Figure::DriveDiscover,
        nominal: Some(Figure::DriveNominal),
        constants: Some(Figure::DriveConstants),
    },
];

/// The whole loop in nested folds.
pub const NESTED: Verb = Verb {
    word: "discover, nested",
    figure: Figure::NestedAfter,
    nominal: None,
    constants: Some(Figure::NestedBefore),
};

/// One result beside its alternatives.
pub struct Judged<'a> {
    pub record: &'a Record,
    pub verb: &'static str,
    /// mm.
    pub value: f64,
    /// Over the nominal robot's, and over that of constants; none where that is not there.
    pub nominal: Option<f64>,
    pub constants: Option<f64>,
}

impl Judged<'_> {
    /// The worse of the two.
    pub fn ratio(&self) -> f64 {
        self.nominal.unwrap_or(0.0).max(self.constants.unwrap_or(0.0))
    }
}

/// A verb's result on one robot; none where it gave none.
pub fn judged<'a>(verb: &Verb, record: &'a Record) -> Option<Judged<'a>> {
    let value = record.get(verb.figure);
    let over = |figure: Option<Figure>| {
        let other = record.get(figure?);
        other.is_finite().then(|| value / other)
    };
    let judged = Judged {
        record,
        verb: verb.word,
        value,
        nominal: over(verb.nominal),
        constants: over(verb.constants),
    };
    (!value.is_nan() && (judged.nominal.is_some() || judged.constants.is_some())).then_some(judged)
}

/// Results that are worse than they may be, and panics, by verb; worst first.
pub fn exceptions(records: &[Record]) -> Vec<Judged<'_>> {
    let mut all: Vec<Judged<'_>> = Vec::new();
    for verb in &VERBS {
        let mut mine: Vec<Judged<'_>> =
            records.iter().filter_map(|r| judged(verb, r)).filter(|j| j.ratio() > BOUND).collect();
        mine.sort_by(|a, b| b.ratio().total_cmp(&a.ratio()));
        all.extend(mine);
    }
    all
}

/// The table of verbs, its list of exceptions, refusals, and what took long.
pub fn harm(records: &[Record]) -> Result<String, Error> {
    let mut text = format!(
        "{} robots; on the truth, at 100 configurations that nobody measured; harm: more than {BOUND} times the nominal robot \
         (after best base, tool and targets) or constants\n",
        records.len()
    );
    for (half, words) in [(false, "even numbers (to work with)"), (true, "odd numbers (locked)")] {
        let mine: Vec<&Record> = records.iter().filter(|r| locked(r.number) == half).collect();
        if !mine.is_empty() {
            writeln!(text, "\n{words}: {} robots", mine.len())?;
            verbs(&mut text, &mine)?;
        }
    }
    writeln!(text, "\nexceptions: number (seed) robot; mm; times nominal, times constants")?;
    for judged in exceptions(records) {
        exception(&mut text, &judged)?;
    }
    refusals(&mut text, records)?;
    slowest(&mut text, records, Figure::SecondsDiscover, "discover")?;
    Ok(text)
}

fn verbs(text: &mut String, records: &[&Record]) -> Result<(), Error> {
    writeln!(
        text,
        "{:22} {:>7} {:>5} {:>10} {:>10} {:>9} {:>9} {:>8}",
        "verb", "results", "harm", "× nominal", "× const.", "worst", "number", "mm"
    )?;
    for verb in &VERBS {
        let mine: Vec<Judged<'_>> = records.iter().filter_map(|r| judged(verb, r)).collect();
        let Some(worst) = mine.iter().max_by(|a, b| a.ratio().total_cmp(&b.ratio())) else { continue };
        let ratio = |of: fn(&Judged<'_>) -> Option<f64>| median(mine.iter().filter_map(of).collect());
        writeln!(
            text,
            "{:22} {:>7} {:>5} {:>10} {:>10} {:>9.3} {:>9} {:>8.3}",
            verb.word,
            mine.len(),
            mine.iter().filter(|j| j.ratio() > BOUND).count(),
            ratio(|j| j.nominal),
            ratio(|j| j.constants),
            worst.ratio(),
            worst.record.number,
            worst.value
        )?;
    }
    writeln!(text, "× nominal, × const.: medians")
}

fn exception(text: &mut String, judged: &Judged<'_>) -> Result<(), Error> {
    let r = judged.record;
    let times = |ratio: Option<f64>| ratio.map_or("–".into(), |ratio| format!("{ratio:.3}"));
    writeln!(
        text,
        "  {:22} {:>4} ({}) {} {} {} {}, {} poses, {} rows; {:.4} mm, noise {:.3}; {}, {}{}{}",
        judged.verb,
        r.number,
        r.seed,
        r.make,
        r.style,
        r.hidden,
        r.spoil,
        r.poses,
        r.rows,
        judged.value,
        r.noise_mm,
        times(judged.nominal),
        times(judged.constants),
        if r.finds.is_empty() { "" } else { "; " },
        r.finds
    )
}

fn refusals(text: &mut String, records: &[Record]) -> Result<(), Error> {
    let all: usize = records.iter().map(|r| r.refused.len()).sum();
    writeln!(text, "\nrefused: {all}")?;
    for r in records {
        for why in &r.refused {
            writeln!(
                text,
                "  {:>4} ({}) {} {} {} {}, {} poses: {why}",
                r.number, r.seed, r.make, r.style, r.hidden, r.spoil, r.poses
            )?;
        }
    }
    Ok(())
}

/// What took longest.
fn slowest(text: &mut String, records: &[Record], figure: Figure, words: &str) -> Result<(), Error> {
    let mut timed: Vec<&Record> = records.iter().filter(|r| r.get(figure).is_finite()).collect();
    timed.sort_by(|a, b| b.get(figure).total_cmp(&a.get(figure)));
    let all: f64 = timed.iter().map(|r| r.get(figure)).sum();
    writeln!(text, "\n{words}: {all:.0} s in all; slowest, wall (processors, where known)")?;
    for r in timed.iter().take(10) {
        writeln!(
            text,
            "  {:>4} ({}) {} {} {} {}, {} poses, {} rows: {:.1} s ({:.1} s); {}",
            r.number,
            r.seed,
            r.make,
            r.style,
            r.hidden,
            r.spoil,
            r.poses,
            r.rows,
            r.get(figure),
            r.get(Figure::Processors),
            r.finds
        )?;
    }
    Ok(())
}

/// Nested folds: each robot in which the whole loop is worse than the declared model.
pub fn nested(records: &[Record]) -> Result<String, Error> {
    let mine: Vec<Judged<'_>> = records.iter().filter_map(|r| judged(&NESTED, r)).collect();
    let mut worse: Vec<&Judged<'_>> = mine.iter().filter(|j| j.ratio() > NESTED_BOUND).collect();
    worse.sort_by(|a, b| b.ratio().total_cmp(&a.ratio()));
    let mut text = format!(
        "{} robots, five nested folds of discover against the declared model in the same folds\n\
         median {}; above {NESTED_BOUND}: {}\n",
        mine.len(),
        median(mine.iter().filter_map(|j| j.constants).collect()),
        worse.len()
    );
    for judged in worse {
        exception(&mut text, judged)?;
    }
    refusals(&mut text, records)?;
    slowest(&mut text, records, Figure::SecondsNested, "nested")?;
    Ok(text)
}

fn median(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).map_or("–".into(), |value| format!("{value:.3}"))
}
