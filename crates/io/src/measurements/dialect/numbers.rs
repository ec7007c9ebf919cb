//! Which mark separates decimals, and which numbers have two readings.

/// What the marks of a number in a cell say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Marks {
    /// No number, or one without marks.
    Plain,
    /// `1,5`, `0,123`, `1.234,5`: the comma separates decimals.
    Comma,
    /// `1.5`, `0.123`, `1,234.5`: the point does.
    Point,
    /// `1,234`: decimals or thousands.
    CommaOrThousands,
    /// `1.234`: thousands or decimals, where commas separate decimals elsewhere.
    PointOrThousands,
}

/// The marks of one cell.
pub(super) fn marks(cell: &str) -> Marks {
    let Some((first, second)) = sorted(cell) else { return Marks::Plain };
    match (first, second) {
        (None, _) => Marks::Plain,
        (Some((mark, before, after, zero)), None) => {
            let thousands = (1..=3).contains(&before) && after == 3 && !zero && exponent(cell).is_none();
            match (mark, thousands) {
                (',', true) => Marks::CommaOrThousands,
                (',', false) => Marks::Comma,
                (_, true) => Marks::PointOrThousands,
                (_, false) => Marks::Point,
            }
        }
        // The last of two different marks separates decimals.
        (Some(_), Some(',')) => Marks::Comma,
        (Some(_), Some(_)) => Marks::Point,
    }
}

/// The number with a decimal point and without thousands; `cell` has marks of which the last separates decimals.
pub(super) fn with_point(cell: &str) -> String {
    match cell.rfind([',', '.']) {
        None => cell.to_owned(),
        Some(at) => {
            let whole: String = cell[..at].chars().filter(|c| !matches!(c, ',' | '.')).collect();
            format!("{whole}.{}", &cell[at + 1..])
        }
    }
}

/// The number without the marks between its groups of three digits, and the mark: `1'234.5`, `12 345,6`. None where it has none, or is no
/// number of groups. An apostrophe or a blank never separates decimals, so that such a number has one reading.
pub(super) fn ungrouped(cell: &str) -> Option<(String, char)> {
    let mark = cell.chars().find(|c| matches!(c, '\'' | '\u{2019}' | ' ' | '\u{a0}' | '\u{202f}'))?;
    let body = cell.strip_prefix(['+', '-', '\u{2212}']).unwrap_or(cell);
    let end = body.find([',', '.']).unwrap_or(body.len());
    let (whole, decimals) = body.split_at(end);
    let digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
    let groups = whole.split(mark).enumerate().all(|(k, group)| {
        digits(group) && if k == 0 { (1..=3).contains(&group.len()) } else { group.len() == 3 }
    });
    let fraction = decimals.is_empty() || digits(&decimals[1..]);
    (groups && fraction).then(|| (cell.chars().filter(|&c| c != mark).collect(), mark))
}

fn exponent(cell: &str) -> Option<&str> {
    cell.find(['e', 'E']).map(|at| &cell[at + 1..])
}

/// Only mark or first of two: the mark, digits before and behind it, and whether the whole part is 0; and the other mark.
type Sorted = (Option<(char, usize, usize, bool)>, Option<char>);

/// The marks of a number in the order of the text; none where the cell is no number.
fn sorted(cell: &str) -> Option<Sorted> {
    let body = cell.strip_prefix(['+', '-', '\u{2212}']).unwrap_or(cell);
    let mantissa = match body.find(['e', 'E']) {
        Some(at) => {
            let power = body[at + 1..].strip_prefix(['+', '-']).unwrap_or(&body[at + 1..]);
            if power.is_empty() || !power.bytes().all(|b| b.is_ascii_digit()) {
                return None;
            }
            &body[..at]
        }
        None => body,
    };
    if mantissa.is_empty() || !mantissa.chars().all(|c| c.is_ascii_digit() || matches!(c, ',' | '.')) {
        return None;
    }
    let places: Vec<(usize, char)> = mantissa.char_indices().filter(|(_, c)| !c.is_ascii_digit()).collect();
    let digits = mantissa.len() - places.len();
    if digits == 0 {
        return None;
    }
    match places[..] {
        [] => Some((None, None)),
        [(at, mark)] => {
            Some((Some((mark, at, mantissa.len() - at - 1, mantissa[..at].starts_with('0'))), None))
        }
        [(_, first), .., (last, mark)] => {
            let grouped = mantissa[..last].split(first).enumerate().all(|(k, group)| match k {
                0 => (1..=3).contains(&group.len()),
                _ => group.len() == 3 && group.bytes().all(|b| b.is_ascii_digit()),
            });
            // `1.234.567` has no decimals; dates and versions look like this, too.
            (first != mark && grouped).then_some((Some((first, 0, 0, false)), Some(mark)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_of_numbers() {
        for (cell, expected) in [
            ("12", Marks::Plain),
            ("", Marks::Plain),
            ("P1", Marks::Plain),
            ("11.03.2024", Marks::Plain),
            ("1,5", Marks::Comma),
            ("-0,123", Marks::Comma),
            ("1234,567", Marks::Comma),
            ("1.234,5", Marks::Comma),
            ("12.345.678,9", Marks::Comma),
            (",5", Marks::Comma),
            ("1,234e-3", Marks::Comma),
            ("1,234", Marks::CommaOrThousands),
            ("1.234", Marks::PointOrThousands),
            ("0.234", Marks::Point),
            ("1.5", Marks::Point),
            ("1,234.5", Marks::Point),
            ("1.2.3,4", Marks::Plain),
        ] {
            assert_eq!(marks(cell), expected, "{cell}");
        }
        assert_eq!(with_point("-1.234,5"), "-1234.5");
        assert_eq!(with_point("1,234.5"), "1234.5");
        assert_eq!(with_point(",5e-3"), ".5e-3");
    }

    #[test]
    fn groups_of_digits_have_one_reading() {
        for (cell, expected) in [
            ("1'234.5", Some("1234.5")),
            ("-1\u{2019}234\u{2019}567,25", Some("-1234567,25")),
            ("12 345,6", Some("12345,6")),
            ("1\u{202f}234", Some("1234")),
            ("1\u{a0}234.", Some("1234.")),
            ("1234.5", None),
            ("1'23", None),
            ("1'2345", None),
            ("1234'567", None),
            ("1'234 567", None),
            ("1'234.5'6", None),
            ("5' 3\"", None),
            ("'234", None),
            ("12 mm", None),
            ("", None),
        ] {
            assert_eq!(ungrouped(cell).map(|(number, _)| number).as_deref(), expected, "{cell}");
        }
    }
}
