//! The tables of a half, in Markdown. Fractions have Wilson's 95 % interval; `–` is not reported or not tried.

use super::cause::Cause;
use super::description::Kind;
use super::record::Record;
use crate::prelude::*;

/// A reported repeatability limit within these multiples of the truth is right.
const NEAR: [f64; 2] = [0.8, 1.25];
/// Poses that are measured twice, from which on their scatter is known to a sixth.
const MANY: f64 = 8.0;
/// Something is left above the first, nothing below the second: systematic error at fresh poses over the noise of a row.
const LEFT: [f64; 2] = [1.0, 0.5];

/// Records under a name.
type Group<'a> = (String, Vec<&'a Record>);
/// A column: its head, and its cell for the records of a row.
type Column = (&'static str, Box<dyn Fn(&[&Record]) -> String>);

fn column(head: &'static str, cell: impl Fn(&[&Record]) -> String + 'static) -> Column {
    (head, Box::new(cell))
}

/// The fraction of the records that have a cell in which it is true.
fn fraction(head: &'static str, name: &'static str) -> Column {
    column(head, move |mine| Fraction::of(mine.iter().filter_map(|record| record.yes(name))).to_string())
}

/// The fraction of the records of which something is true.
fn share(head: &'static str, is: fn(&Record) -> bool) -> Column {
    column(head, move |mine| Fraction::of(mine.iter().map(|record| is(record))).to_string())
}

/// Median, 10 % and 90 %.
fn spread(head: &'static str, name: &'static str) -> Column {
    column(head, move |mine| quantiles(numbers(mine, name)))
}

fn numbers(records: &[&Record], name: &str) -> Vec<f64> {
    records.iter().filter_map(|record| record.number(name)).collect()
}

fn any_finding(record: &Record) -> bool {
    record.number("findings") > Some(0.0)
}

fn select<'a>(records: &[&'a Record], is: impl Fn(&Record) -> bool) -> Vec<&'a Record> {
    records.iter().copied().filter(|record| is(record)).collect()
}

fn of_kind<'a>(records: &[&'a Record], kind: Kind) -> Vec<&'a Record> {
    select(records, |record| record.text("kind") == kind.word())
}

fn by_cell<'a>(records: &[&'a Record], kind: Kind) -> Vec<Group<'a>> {
    let here = of_kind(records, kind);
    let of = |cell: String| (cell.clone(), select(&here, |record| record.text("cell") == cell));
    kind.cells().into_iter().map(of).collect()
}

fn by_cause<'a>(here: &[&'a Record], causes: &[Cause]) -> Vec<Group<'a>> {
    let of = |cause: &Cause| (cause.word(), select(here, |record| record.text("cause") == cause.word()));
    causes.iter().map(of).collect()
}

/// A row for each group that has records: its name, their number, and the columns.
fn table(head: &str, groups: &[Group<'_>], columns: &[Column]) -> String {
    let heads: String = columns.iter().map(|(head, _)| format!("|{head}")).collect();
    let mut table = Table::markdown(&format!("{head}|robots{heads}"));
    for (name, mine) in groups.iter().filter(|(_, mine)| !mine.is_empty()) {
        let mut cells = vec![name.clone(), mine.len().to_string()];
        cells.extend(columns.iter().map(|(_, cell)| cell(mine)));
        table.cells(&cells);
    }
    table.text()
}

/// The same, or nothing where no group has records.
fn table_of_some(head: &str, groups: &[Group<'_>], columns: &[Column]) -> String {
    let some = groups.iter().any(|(_, mine)| !mine.is_empty());
    if some { table(head, groups, columns) } else { String::new() }
}

/// All tables.
pub fn all(records: &[Record]) -> Outcome<String> {
    let ended: Vec<&Record> = records.iter().filter(|record| record.ended()).collect();
    let parts = [
        power(&ended),
        unweighed(&ended),
        everything(&ended),
        words(&ended),
        outside(&ended),
        alarms(&ended),
        limits(&ended),
        verdicts(&ended),
        names(&ended)?,
        intervals(&ended),
        bad(&ended),
        harm(&ended),
        screen(&ended),
        errors(records)?,
    ];
    Ok(parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("\n"))
}

fn power(records: &[&Record]) -> String {
    let here = of_kind(records, Kind::Power);
    if here.is_empty() {
        return String::new();
    }
    let columns = [
        fraction("found", "found"),
        fraction("named first", "first_right"),
        fraction("first or listed", "listed"),
        share("any finding", any_finding),
    ];
    let poses = table("cause at 5 × the noise, poses", &by_cell(&here, Kind::Power), &columns);
    let many = select(&here, |record| record.number("poses") >= Some(30.0));
    let causes = by_cause(&many, Cause::with_family());
    poses + "\n" + &table("cause at 5 × the noise, 30 poses or more", &causes, &columns)
}

fn unweighed(records: &[&Record]) -> String {
    let columns = [
        share("any finding", any_finding),
        fraction("named first", "first_right"),
        fraction("first or listed", "listed"),
        fraction("confidently wrong", "confident_wrong"),
    ];
    let cells = by_cell(records, Kind::Unweighed);
    table_of_some("weights not declared, cause at 5 × the noise, 30 to 100 poses", &cells, &columns)
}

fn words(records: &[&Record]) -> String {
    let columns = [
        share("any finding", any_finding),
        fraction("named first", "first_right"),
        fraction("named first or listed", "listed"),
        spread("held-out error over that with the right effect declared: median (10–90 %)", "oracle_ratio"),
        spread("over that without the cause", "held_ratio"),
    ];
    let rows = by_cause(&of_kind(records, Kind::Words), Cause::with_word());
    table_of_some("row of the vocabulary, 5 × the noise, 130 poses", &rows, &columns)
}

fn everything(records: &[&Record]) -> String {
    let fresh = |record: &&Record| {
        let (error, noise) = (record.number("fresh_mm")?, record.number("floor_mm")?);
        Some(error.hypot(noise) / noise)
    };
    let columns = [
        fraction("a cause that is there first", "first_right"),
        fraction("the two largest named", "found"),
        spread("findings", "findings"),
        spread("error of fresh rows over the noise: before,", "executed_before"),
        column("after", move |mine| quantiles(mine.iter().filter_map(fresh))),
        spread("the true robot, commanded by the model, over the noise", "executed"),
    ];
    table_of_some("everything at once, poses", &by_cell(records, Kind::Everything), &columns)
}

fn outside(records: &[&Record]) -> String {
    let columns = [
        share("any finding", any_finding),
        fraction("a right place first", "first_right"),
        share("verdict not adequate, or a finding", |r| r.text("verdict") != "adequate" || any_finding(r)),
        spread("fresh error over that with nothing hidden", "fresh_ratio"),
    ];
    let causes = by_cause(&of_kind(records, Kind::Outside), Cause::without_word());
    table_of_some("cause without a word, 2–10 × the noise", &causes, &columns)
}

fn alarms(records: &[&Record]) -> String {
    let named = |record: &&&Record| !["none", "unmodelled"].contains(&record.text("first"));
    let columns = [
        fraction("false alarms", "alarm"),
        column("a name among them", move |mine| mine.iter().filter(named).count().to_string()),
        share("rows called outliers", |r| r.number("outliers") > Some(0.0)),
        spread("autocorrelation reported", "autocorrelation"),
    ];
    let kinds = [Kind::Null, Kind::Memory, Kind::Flicker, Kind::Columns, Kind::Joints, Kind::Stated];
    let of = |kind: Kind| {
        let cells = by_cell(records, kind).into_iter();
        cells.map(move |(cell, mine)| (format!("{} {cell}", kind.word()), mine))
    };
    table_of_some("nothing hidden", &kinds.into_iter().flat_map(of).collect::<Vec<_>>(), &columns)
}

/// Probabilities that were given, and whether they came true.
fn events(records: &[&Record]) -> Vec<(f64, bool)> {
    let one = |text: &str| {
        let (probability, hit) = text.split_once(':')?;
        Some((probability.parse().ok()?, hit == "1"))
    };
    records.iter().flat_map(|r| r.text("names").split('|').filter_map(one).collect::<Vec<_>>()).collect()
}

fn names(records: &[&Record]) -> Outcome<String> {
    let side = |inside: bool| select(records, |record| record.yes("inside") == Some(inside));
    let (inside, outside) = (side(true), side(false));
    if inside.len() + outside.len() == 0 {
        return Ok(String::new());
    }
    // A version that reports no probabilities is never confident.
    let reported = !events(records).is_empty();
    let mut table =
        Table::markdown("names|robots|Brier score|confidently wrong (above 0.9, the truth not listed)");
    for (name, mine) in [("inside the vocabulary", &inside), ("without a word", &outside)] {
        let score = brier(&events(mine)).map_or("–".into(), |score| fixed(score, 3));
        let wrong = Fraction::of(mine.iter().filter(|_| reported).filter_map(|r| r.yes("confident_wrong")));
        table.row(&[&name, &mine.len(), &score, &wrong]);
    }
    let mut text = table.text();
    let every: Vec<(f64, bool)> = events(&inside).into_iter().chain(events(&outside)).collect();
    if !every.is_empty() {
        let mut table = Table::markdown("probability reported|mean|came true");
        let edges = [0.0, 0.05, 0.2, 0.5, 0.8, 0.95, 1.0];
        for (pair, (mean, hits)) in edges.windows(2).zip(calibration(&every, &edges)) {
            table.row(&[&format!("{} to {}", pair[0], pair[1]), &fixed(mean, 2), &hits]);
        }
        write!(text, "\n{}", table.text())?;
    }
    Ok(text)
}

fn limits(records: &[&Record]) -> String {
    // A campaign with stated deviations that are wrong is a case of its own; an estimate from few repeats scatters.
    let group = |record: &Record| {
        let source = match record.text("floor_source") {
            "" => "not reported",
            "repeats" if record.number("repeats") < Some(MANY) => "repeats, fewer than 8 poses twice",
            "repeats" => "repeats, 8 poses or more twice",
            source => source,
        };
        let wrong = record.text("kind") == Kind::Stated.word();
        format!("{source}{}", if wrong { ", stated wrongly" } else { "" })
    };
    let mut names: Vec<String> = records.iter().map(|record| group(record)).collect();
    names.sort_unstable();
    names.dedup();
    let of = |name: String| (name.clone(), select(records, |record| group(record) == name));
    let near = |ratio: &f64| (NEAR[0]..=NEAR[1]).contains(ratio);
    let columns = [
        column("within 0.8–1.25 of the truth", move |mine| {
            Fraction::of(numbers(mine, "floor_ratio").iter().map(near)).to_string()
        }),
        spread("reported over true: median (10–90 %)", "floor_ratio"),
        fraction("interval contains the truth", "floor_covered"),
    ];
    table("repeatability limit, source", &names.into_iter().map(of).collect::<Vec<_>>(), &columns)
}

fn verdicts(records: &[&Record]) -> String {
    let judged = select(records, |r| r.number("left").is_some() && r.text("kind") != "bad");
    if judged.is_empty() {
        return String::new();
    }
    let mut table = Table::markdown("truth|robots|adequate|undecided|unexplained|not reported|as required");
    let something = select(&judged, |record| record.number("left") > Some(LEFT[0]));
    let nothing = select(&judged, |record| record.number("left") < Some(LEFT[1]));
    for (name, mine, right) in [
        ("something is left (more than the noise)", something, ["unexplained", "undecided"]),
        ("nothing is left (less than half of it)", nothing, ["adequate", "undecided"]),
    ] {
        let count = |word: &str| mine.iter().filter(|r| r.text("verdict") == word).count();
        let [a, b, c, d] = ["adequate", "undecided", "unexplained", ""].map(count);
        let reported = mine.iter().map(|r| r.text("verdict")).filter(|verdict| !verdict.is_empty());
        let required = Fraction::of(reported.map(|verdict| right.contains(&verdict)));
        table.row(&[&name, &mine.len(), &a, &b, &c, &d, &required]);
    }
    table.text()
}

fn intervals(records: &[&Record]) -> String {
    let mut table = Table::markdown("95 % interval of|contains the truth");
    for (name, column) in [
        ("the held-out error before", "before_covered"),
        ("the held-out error after", "after_covered"),
        ("the gain", "gain_covered"),
    ] {
        table.row(&[&name, &fraction("", column).1(records)]);
    }
    table.text()
}

fn bad(records: &[&Record]) -> String {
    let whole = |head, name: &'static str| {
        let all = move |record: &&Record| record.number(name) >= record.number("bad");
        column(head, move |mine| Fraction::of(mine.iter().map(all)).to_string())
    };
    let near = |head, name: &'static str| {
        let near = |ratio: &f64| (ratio - 1.0).abs() < 0.1;
        column(head, move |mine| Fraction::of(numbers(mine, name).iter().map(near)).to_string())
    };
    let columns = [
        spread("least displaced, in deviations of a row", "bad_least"),
        whole("all reported", "bad_reported"),
        whole("all reported or called suspect", "bad_known"),
        whole("some row of each reported", "bad_partly"),
        near("limit within 10 % of that without", "bad_floor_ratio"),
        near("error within 10 % of that without", "bad_fresh_ratio"),
        spread("error over that without", "bad_fresh_ratio"),
    ];
    table_of_some("bad poses of 100", &by_cell(records, Kind::Bad), &columns)
}

fn harm(records: &[&Record]) -> String {
    let of = |kind: &Kind| (kind.word(), of_kind(records, *kind));
    let columns = [
        fraction("worse than the declared model by more than 5 %", "harm"),
        spread("held-out RMS over its noise", "ratio"),
        spread("fresh error over that with nothing hidden, after", "fresh_ratio"),
        spread("before", "declared_ratio"),
    ];
    table("predictions", &Kind::all().iter().map(of).collect::<Vec<_>>(), &columns)
}

fn screen(records: &[&Record]) -> String {
    let p = numbers(&of_kind(records, Kind::Null), "p_first");
    if p.is_empty() {
        return String::new();
    }
    let (distance, probability) = uniformity(&p);
    let below = Fraction::of(p.iter().map(|p| *p < 0.05));
    let mut table = Table::markdown(
        "p of the first screen, nothing hidden|robots|distance from uniform|probability of a larger one|below 0.05|median",
    );
    let (distance, probability) = (fixed(distance, 3), fixed(probability, 2));
    table.row(&[&"null", &p.len(), &distance, &probability, &below, &fixed(upper_median(p.clone()), 2)]);
    table.text()
}

fn errors(records: &[Record]) -> Outcome<String> {
    let failed = records.iter().filter(|record| !record.ended());
    let (no_plant, refused): (Vec<&Record>, Vec<&Record>) =
        failed.partition(|record| record.text("ended").starts_with("no plant"));
    let counts = (records.len(), no_plant.len(), refused.len());
    let mut text = format!("{} robots; {} without a plant, {} refused.\n", counts.0, counts.1, counts.2);
    for r in refused.iter().take(20) {
        writeln!(text, "* {} {} {}: {}", r.text("kind"), r.text("cell"), r.text("number"), r.text("ended"))?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(kind: Kind, cell: &str, number: u64, cells: &str) -> Record {
        let mut record = Record::new(kind.key(Half::Tuning, number), kind, cell);
        record.set("ended", "yes");
        cells.split_whitespace().filter_map(|cell| cell.split_once('=')).for_each(|(k, v)| record.set(k, v));
        record
    }

    #[test]
    fn what_is_not_reported_is_not_counted() {
        let found = "found=true first_right=true listed=true cause=mesh inside=true poses=30 findings=1 \
                     names=0.9000:1|0.1000:0 left=0.1 verdict=adequate floor_source=repeats repeats=9 floor_ratio=1.1";
        let records = [
            record(Kind::Null, "", 0, "alarm=false findings=0 p_first=0.4 first=none"),
            record(Kind::Null, "", 1, "alarm=true findings=1 p_first=0.001 first=drift"),
            record(Kind::Power, "30", 0, found),
        ];
        let text = all(&records).expect("a table");
        for line in [
            "| null  | 2 | 1/2, 50 % (9–91) | 1 |",
            "| 30 | 1 | 1/1, 100 % (21–100) |",
            "| repeats, 8 poses or more twice | 1 | 1/1, 100 % (21–100) | 1.10 (1.10–1.10) | – |",
            // (0.1² + 0.1²)/2.
            "| inside the vocabulary | 1 | 0.010 | – |",
            "| the gain | – |",
            "| nothing is left (less than half of it) | 1 | 1 | 0 | 0 | 0 | 1/1",
        ] {
            assert!(text.contains(line), "{line}: {text}");
        }
    }

    #[test]
    fn a_version_without_probabilities_is_not_called_careful() {
        let records = [record(Kind::Power, "30", 0, "inside=true cause=mesh confident_wrong=false")];
        let text = all(&records).expect("a table");
        assert!(text.contains("| inside the vocabulary | 1 | – | – |"), "{text}");
    }

    #[test]
    fn robots_without_a_plant_are_counted_apart() {
        let mut failed = record(Kind::Power, "20", 0, "");
        failed.set("ended", "no plant: no place");
        let mut refused = record(Kind::Power, "20", 1, "");
        refused.set("ended", "too few poses");
        let text = all(&[failed, refused]).expect("a table");
        assert!(text.contains("2 robots; 1 without a plant, 1 refused."), "{text}");
        assert!(text.contains("* power 20 1: too few poses"), "{text}");
    }
}
