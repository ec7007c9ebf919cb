//! A column as far as it shows without knowing what it is: the words of its header, its unit, its first values.

use super::super::beside_kind::is_numbered;
use super::super::cells::number;
use super::super::columns::Role;
use super::super::names::{Named, Names};
use super::super::sampled::Sample;
use super::super::spelled_units::{split_unit, unit_in_words};
use crate::Unit;

/// A column of the file.
pub(super) struct Seen<'a> {
    pub header: &'a str,
    /// Words of the name in lower case: `MeasX`, `Mess. X` and `meas_x` have two each; numbers are words of their own.
    pub words: Vec<String>,
    /// The unit that the header names.
    pub unit: Option<&'a str>,
    /// The unit is a word among others, as in `Rx (Fixed XYZ deg)`.
    pub unit_in_words: bool,
    /// Its meaning, where the name says it.
    pub role: Option<Role>,
    /// Not left out, without a meaning, and not proposed for something yet.
    pub free: bool,
    /// Cells of the first rows.
    pub cells: Vec<&'a str>,
}

impl Seen<'_> {
    /// The numbers of the first rows, NaN where a cell is empty; none where some cell is a text, or all are empty.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        let one = |cell: &&str| number(cell).ok().map(|value| value.unwrap_or(f64::NAN));
        let all: Option<Vec<f64>> = self.cells.iter().map(one).collect();
        all.filter(|all| all.iter().any(|value| value.is_finite()))
    }

    /// Smallest and largest number of the first rows.
    pub fn range(&self) -> Option<(f64, f64)> {
        let numbers = self.numbers()?;
        let finite = || numbers.iter().copied().filter(|value| value.is_finite());
        Some((finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max)))
    }

    /// Whether its numbers may be read: some are numbers, or nothing is known of them.
    pub fn may_be_numbers(&self) -> bool {
        self.cells.is_empty() || self.numbers().is_some()
    }

    /// The unit of the header.
    pub fn measure(&self) -> Option<&'static Unit> {
        self.unit.and_then(Unit::named)
    }

    /// Whether one of these is among its words.
    pub fn has(&self, words: &[&str]) -> bool {
        self.words.iter().any(|word| words.contains(&word.as_str()))
    }
}

/// The columns of a file.
pub(super) fn see<'a>(headers: &[&'a str], sample: &'a Sample, names: &Names<'_>) -> Vec<Seen<'a>> {
    let mut all = Vec::new();
    for (k, &header) in headers.iter().enumerate() {
        let resolved = names.resolve(header);
        let (ours, given) = match &resolved {
            Named::Ignored => (String::new(), None),
            Named::Header(text) => {
                let (name, unit) = split_unit(text);
                (name.to_owned(), unit.map(str::to_owned))
            }
        };
        let role = names.role(&ours);
        let (name, unit) = split_unit(header);
        let worded = if unit.is_none() { unit_in_words(header) } else { None };
        // A unit that the user gave counts as the header's.
        let unit =
            unit.or(worded).or_else(|| given.and_then(|unit| Unit::named(&unit)).map(|unit| unit.word));
        all.push(Seen {
            header,
            words: words(name),
            unit,
            unit_in_words: worded.is_some(),
            role,
            free: role.is_none()
                && ours == name
                && resolved != Named::Ignored
                && !header.is_empty()
                && !header.starts_with("command_"),
            cells: sample.cells(k).collect(),
        });
    }
    if all.iter().any(|column| column.role == Some(Role::Kind)) {
        let meant = |column: &&mut Seen<'_>| is_numbered(split_unit(column.header).0);
        all.iter_mut().filter(meant).for_each(|column| column.free = false);
    }
    all
}

/// Words of a name that are looked at: no person writes more.
const MOST_WORDS: usize = 32;

/// Letters apart from digits, and at capitals behind small letters; the first ones of a name that never ends.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    let mut last: Option<char> = None;
    for c in name.chars() {
        if c.is_alphanumeric() {
            let begins = last.is_none_or(|last| {
                !last.is_alphanumeric()
                    || last.is_ascii_digit() != c.is_ascii_digit()
                    || (last.is_lowercase() && c.is_uppercase())
            });
            if begins && all.len() == MOST_WORDS {
                break;
            }
            if begins {
                all.push(String::new());
            }
            if let Some(word) = all.last_mut() {
                word.extend(c.to_lowercase());
            }
        }
        last = Some(c);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fall_into_words_and_end_somewhere() {
        assert_eq!(words("MeasX"), ["meas", "x"]);
        assert_eq!(words("Mess. X_12"), ["mess", "x", "12"]);
        assert_eq!(words(&"1[deg]".repeat(2000)).len(), MOST_WORDS);
    }
}
