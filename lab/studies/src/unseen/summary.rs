//! The tables of a half, in Markdown. Fractions have Wilson's 95 % interval; `–` is not reported or not tried.

use super::record::Record;
use super::{found, judged};
use std::fmt::{Error, Write};

/// All tables.
pub fn all(records: &[Record]) -> Result<String, Error> {
    let ended: Vec<&Record> = records.iter().filter(|record| record.ended()).collect();
    let parts = [
        found::power(&ended)?,
        found::unweighed(&ended)?,
        found::everything(&ended)?,
        found::words(&ended)?,
        found::outside(&ended)?,
        found::alarms(&ended)?,
        judged::limits(&ended)?,
        judged::verdicts(&ended)?,
        found::names(&ended)?,
        judged::intervals(&ended)?,
        judged::bad(&ended)?,
        judged::harm(&ended)?,
        judged::screen(&ended)?,
        errors(records)?,
    ];
    Ok(parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("\n"))
}

fn errors(records: &[Record]) -> Result<String, Error> {
    let mut text = String::new();
    let failed: Vec<&Record> = records.iter().filter(|record| !record.ended()).collect();
    writeln!(
        text,
        "{} robots; {} without a plant, {} refused.",
        records.len(),
        failed.iter().filter(|r| r.text("ended").starts_with("no plant")).count(),
        failed.iter().filter(|r| !r.text("ended").starts_with("no plant")).count()
    )?;
    for r in failed.iter().filter(|r| !r.text("ended").starts_with("no plant")).take(20) {
        writeln!(text, "* {} {} {}: {}", r.text("kind"), r.text("cell"), r.text("number"), r.text("ended"))?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::super::description::Kind;
    use super::super::stream::Half;
    use super::*;

    fn record(kind: Kind, cell: &str, number: u64, cells: &[(&str, &str)]) -> Record {
        let mut record = Record::new(kind.key(Half::Tuning, number), kind, cell);
        record.set("ended", "yes");
        for (column, value) in cells {
            record.set(column, value);
        }
        record
    }

    #[test]
    fn what_is_not_reported_is_not_counted() {
        let records = [
            record(
                Kind::Null,
                "",
                0,
                &[("alarm", "false"), ("findings", "0"), ("p_first", "0.4"), ("first", "none")],
            ),
            record(
                Kind::Null,
                "",
                1,
                &[("alarm", "true"), ("findings", "1"), ("p_first", "0.001"), ("first", "drift")],
            ),
            record(
                Kind::Power,
                "30",
                0,
                &[
                    ("found", "true"),
                    ("first_right", "true"),
                    ("listed", "true"),
                    ("cause", "mesh"),
                    ("inside", "true"),
                    ("poses", "30"),
                    ("findings", "1"),
                    ("names", "0.9000:1|0.1000:0"),
                    ("left", "0.1"),
                    ("verdict", "adequate"),
                    ("floor_source", "repeats"),
                    ("repeats", "9"),
                    ("floor_ratio", "1.1"),
                ],
            ),
        ];
        let text = all(&records).expect("a table");
        assert!(text.contains("| null  | 2 | 1/2, 50 % (9–91) | 1 |"), "{text}");
        assert!(text.contains("| 30 | 1 | 1/1, 100 % (21–100) |"), "{text}");
        assert!(
            text.contains(
                "| repeats, 8 poses or more twice | 1 | 1/1, 100 % (21–100) | 1.10 (1.10–1.10) | – |"
            ),
            "{text}"
        );
        // (0.1² + 0.1²)/2.
        assert!(text.contains("| inside the vocabulary | 1 | 0.010 | – |"), "{text}");
        assert!(text.contains("| the gain | – |"), "{text}");
        assert!(
            text.contains("| nothing is left (less than half of it) | 1 | 1 | 0 | 0 | 0 | 1/1"),
            "{text}"
        );
    }

    #[test]
    fn a_version_without_probabilities_is_not_called_careful() {
        let silent = [("inside", "true"), ("cause", "mesh"), ("confident_wrong", "false")];
        let records = [record(Kind::Power, "30", 0, &silent)];
        let text = all(&records).expect("a table");
        assert!(text.contains("| inside the vocabulary | 1 | – | – |"), "{text}");
    }

    #[test]
    fn robots_without_a_plant_are_counted_apart() {
        let mut failed = record(Kind::Power, "20", 0, &[]);
        failed.set("ended", "no plant: no place");
        let mut refused = record(Kind::Power, "20", 1, &[]);
        refused.set("ended", "too few poses");
        let text = all(&[failed, refused]).expect("a table");
        assert!(text.contains("2 robots; 1 without a plant, 1 refused."), "{text}");
        assert!(text.contains("* power 20 1: too few poses"), "{text}");
    }
}
