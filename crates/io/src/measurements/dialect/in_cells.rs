//! Units that stand in the cells: `-14.926 deg` in every row of a column.

use crate::{Quantity, Unit};

/// The number of a cell as text, and the unit behind it.
pub(super) fn parted(cell: &str) -> Option<(&str, &str)> {
    let end = cell.rfind(|c: char| c.is_ascii_digit() || matches!(c, '.' | ','))? + 1;
    let (number, unit) = (cell[..end].trim(), cell[end..].trim());
    let digits = number.chars().all(|c| c.is_ascii_digit() || "+-.,eE".contains(c));
    let measures = Unit::named(unit).is_some_and(|unit| !matches!(unit.quantity, Quantity::Ratio));
    (digits && measures && number.contains(|c: char| c.is_ascii_digit())).then_some((number, unit))
}

/// Of each column the unit that all filled cells of these rows have.
pub(super) fn units(rows: &[Vec<String>], count: usize) -> Vec<Option<String>> {
    let one = |k: usize| {
        let mut cells = rows.iter().filter_map(|row| row.get(k)).filter(|cell| !cell.is_empty());
        let (_, unit) = parted(cells.next()?)?;
        cells.all(|cell| parted(cell).is_some_and(|(_, other)| other == unit)).then(|| unit.to_owned())
    };
    (0..count).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_units() {
        assert_eq!(parted("-14.926 deg"), Some(("-14.926", "deg")));
        assert_eq!(parted("14,9°"), Some(("14,9", "°")));
        for other in ["14.9", "deg", "P1 mm", "12 apples", "3 m 2 mm", ""] {
            assert_eq!(parted(other), None, "{other}");
        }
        let rows = |cells: &[&str]| cells.iter().map(|cell| vec![(*cell).to_owned()]).collect::<Vec<_>>();
        assert_eq!(units(&rows(&["1 mm", "", "2 mm"]), 1), [Some("mm".to_owned())]);
        assert_eq!(units(&rows(&["1 mm", "2 m"]), 1), [None]);
        assert_eq!(units(&rows(&["1 mm", "2"]), 1), [None]);
    }
}
