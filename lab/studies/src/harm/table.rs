//! Tables: how often each verb did harm, where, and what took long.

use super::record::{Figure, Record};
use super::robots::locked;
use crate::prelude::*;

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
        Verb::against(word, figure, Some(Figure::Nominal), Some(Figure::Constants))
    }

    const fn against(
        word: &'static str,
        figure: Figure,
        nominal: Option<Figure>,
        constants: Option<Figure>,
    ) -> Self {
        Verb { word, figure, nominal, constants }
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
    Verb::against("compensate (identify)", Figure::DriveConstants, Some(Figure::DriveNominal), None),
    Verb::against(
        "compensate (discover)",
        Figure::DriveDiscover,
        Some(Figure::DriveNominal),
        Some(Figure::DriveConstants),
    ),
];

/// The whole loop in nested folds.
pub const NESTED: Verb =
    Verb::against("discover, nested", Figure::NestedAfter, None, Some(Figure::NestedBefore));

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
    let (nominal, constants) = (over(verb.nominal), over(verb.constants));
    let judged = Judged { record, verb: verb.word, value, nominal, constants };
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
pub fn harm(records: &[Record]) -> Outcome<String> {
    let mut text = format!(
        "{} robots; on the truth, at 100 configurations that nobody measured; harm: more than {BOUND} times the nominal robot \
         (after best base, tool and targets) or constants\n",
        records.len()
    );
    for (half, words) in [(false, "even numbers (to work with)"), (true, "odd numbers (locked)")] {
        let mine: Vec<&Record> = records.iter().filter(|r| locked(r.number) == half).collect();
        if !mine.is_empty() {
            write!(text, "\n{words}: {} robots\n{}× nominal, × const.: medians\n", mine.len(), verbs(&mine))?;
        }
    }
    writeln!(text, "\nexceptions: number (seed) robot; mm; times nominal, times constants")?;
    exceptions(records).iter().try_for_each(|judged| exception(&mut text, judged))?;
    refusals(&mut text, records)?;
    slowest(&mut text, records, Figure::SecondsDiscover, "discover")?;
    Ok(text)
}

fn verbs(records: &[&Record]) -> String {
    let mut table =
        Table::columns("verb -22|results 7|harm 5|× nominal 10|× const. 10|worst 9|number 9|mm 8");
    for verb in &VERBS {
        let mine: Vec<Judged<'_>> = records.iter().filter_map(|r| judged(verb, r)).collect();
        let Some(worst) = mine.iter().max_by(|a, b| a.ratio().total_cmp(&b.ratio())) else { continue };
        let harmed = mine.iter().filter(|j| j.ratio() > BOUND).count();
        let nominal = median(mine.iter().filter_map(|j| j.nominal));
        let constants = median(mine.iter().filter_map(|j| j.constants));
        let (ratio, value, number) = (fixed(worst.ratio(), 3), fixed(worst.value, 3), worst.record.number);
        table.row(&[&verb.word, &mine.len(), &harmed, &nominal, &constants, &ratio, &number, &value]);
    }
    table.text()
}

fn exception(text: &mut String, judged: &Judged<'_>) -> Outcome {
    let r = judged.record;
    let times = |ratio: Option<f64>| ratio.map_or("–".into(), |ratio| fixed(ratio, 3));
    let (nominal, constants) = (times(judged.nominal), times(judged.constants));
    write!(text, "  {:22} {}, {} rows; {:.4} mm", judged.verb, r.words(), r.rows, judged.value)?;
    let separator = if r.finds.is_empty() { "" } else { "; " };
    writeln!(text, ", noise {:.3}; {nominal}, {constants}{separator}{}", r.noise_mm, r.finds)?;
    Ok(())
}

fn refusals(text: &mut String, records: &[Record]) -> Outcome {
    let all: usize = records.iter().map(|r| r.refused.len()).sum();
    writeln!(text, "\nrefused: {all}")?;
    for r in records {
        r.refused.iter().try_for_each(|why| writeln!(text, "  {}: {why}", r.words()))?;
    }
    Ok(())
}

/// What took longest.
fn slowest(text: &mut String, records: &[Record], figure: Figure, words: &str) -> Outcome {
    let mut timed: Vec<&Record> = records.iter().filter(|r| r.get(figure).is_finite()).collect();
    timed.sort_by(|a, b| b.get(figure).total_cmp(&a.get(figure)));
    let all: f64 = timed.iter().map(|r| r.get(figure)).sum();
    writeln!(text, "\n{words}: {all:.0} s in all; slowest, wall (processors, where known)")?;
    for r in timed.iter().take(10) {
        let (wall, processors) = (r.get(figure), r.get(Figure::Processors));
        writeln!(text, "  {}, {} rows: {wall:.1} s ({processors:.1} s); {}", r.words(), r.rows, r.finds)?;
    }
    Ok(())
}

/// Nested folds: each robot in which the whole loop is worse than the declared model.
pub fn nested(records: &[Record]) -> Outcome<String> {
    let mine: Vec<Judged<'_>> = records.iter().filter_map(|r| judged(&NESTED, r)).collect();
    let mut worse: Vec<&Judged<'_>> = mine.iter().filter(|j| j.ratio() > NESTED_BOUND).collect();
    worse.sort_by(|a, b| b.ratio().total_cmp(&a.ratio()));
    let mut text = format!(
        "{} robots, five nested folds of discover against the declared model in the same folds\n\
         median {}; above {NESTED_BOUND}: {}\n",
        mine.len(),
        median(mine.iter().filter_map(|j| j.constants)),
        worse.len()
    );
    worse.into_iter().try_for_each(|judged| exception(&mut text, judged))?;
    refusals(&mut text, records)?;
    slowest(&mut text, records, Figure::SecondsNested, "nested")?;
    Ok(text)
}

fn median(values: impl Iterator<Item = f64>) -> String {
    let median = upper_median(values);
    if median.is_nan() { "–".into() } else { fixed(median, 3) }
}
