//! Units in headers as people spell them.

use crate::{Quantity, Unit};

/// Name and unit of a header in any of the usual spellings: `x[mm]`, `x (mm)`, `x mm`, `x_mm`, `x/mm`, `x in mm`, `x°`.
pub(super) fn split_unit(header: &str) -> (&str, Option<&str>) {
    let header = header.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((name, rest)) = header.rsplit_once(open)
            && let Some(unit) = rest.trim_end().strip_suffix(close)
            && (open == '[' || Unit::named(unit.trim()).is_some())
        {
            return (name.trim(), Some(unit.trim()));
        }
    }
    let known = |unit: &str| Unit::named(unit).is_some_and(|unit| unit.quantity != Quantity::Ratio);
    if let Some((name, unit)) = header.rsplit_once([' ', '_', '/', ','])
        && known(unit.trim())
    {
        let name = name.trim_end().trim_end_matches(['/', ',']).trim_end();
        return (name.strip_suffix(" in").unwrap_or(name).trim_end(), Some(unit.trim()));
    }
    match header.strip_suffix('°') {
        Some(name) if !name.trim().is_empty() => (name.trim(), Some("°")),
        _ => (header, None),
    }
}

/// The unit that stands among other words in brackets: `Rx (Fixed XYZ deg)`; none where there are several.
pub(super) fn unit_in_words(header: &str) -> Option<&'static str> {
    let inside = header.trim().strip_suffix([')', ']'])?.rsplit_once(['(', '['])?.1;
    // Letters alone (m, s, h, N) are rather something else, and so is `in`.
    let long = |word: &&str| (word.chars().count() > 1 && *word != "in") || *word == "°";
    let unit = |word: &str| Unit::named(word).filter(|unit| unit.quantity != Quantity::Ratio);
    let mut units = inside.split([' ', ',', ';', '/']).filter(long).filter_map(unit);
    units.next().filter(|_| units.next().is_none()).map(|unit| unit.word)
}

/// Whether a cell of a row below the header is a unit.
pub(super) fn is_unit_word(cell: &str) -> bool {
    let word = cell.trim_matches(['[', ']', '(', ')']).trim();
    matches!(word, "-" | "–") || (word.parse::<f64>().is_err() && Unit::named(word).is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_units() {
        for (header, expected) in [
            ("x[mm]", ("x", Some("mm"))),
            ("x (mm)", ("x", Some("mm"))),
            ("x_mm", ("x", Some("mm"))),
            ("x / mm", ("x", Some("mm"))),
            ("x in mm", ("x", Some("mm"))),
            ("Joint 1[°]", ("Joint 1", Some("°"))),
            ("Joint 1°", ("Joint 1", Some("°"))),
            ("Joint 1", ("Joint 1", None)),
            ("approach_d1", ("approach_d1", None)),
            ("temp (outside)", ("temp (outside)", None)),
        ] {
            assert_eq!(split_unit(header), expected);
        }
    }

    #[test]
    fn units_among_words() {
        assert_eq!(unit_in_words("Rx (Fixed XYZ deg)"), Some("deg"));
        assert_eq!(unit_in_words("X (world, mm)"), Some("mm"));
        assert_eq!(unit_in_words("X (from mm to um)"), None);
        assert_eq!(unit_in_words("temp (outside in s)"), None);
        assert_eq!(unit_in_words("temp"), None);
    }
}
