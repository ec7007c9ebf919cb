//! The centre of gravity of what is carried, where it is the same in all rows and no column of the file: `--map "cz=120mm"`, or `cz = "120 mm"`
//! in `[columns]` of the robot file.

use super::mapping::ColumnMap;
use super::spelled_units::split_unit;
use crate::{Quantity, Unit};

/// Its names, in the order of x, y and z.
const CENTRE: [&str; 3] = ["cx", "cy", "cz"];

/// The length that a name is mapped to instead of a column, m: a number with its unit. None for columns and for other names.
pub(super) fn length((ours, theirs): (&str, &str)) -> Option<f64> {
    if !CENTRE.contains(&ours) {
        return None;
    }
    let (number, unit) = match split_unit(theirs) {
        (number, Some(unit)) => (number, unit),
        (whole, None) => whole.split_at(whole.find(|c: char| c.is_alphabetic() || c == '\u{b5}')?),
    };
    let unit = Unit::named(unit.trim()).filter(|unit| unit.quantity == Quantity::Length)?;
    let value: f64 = number.trim().parse().ok()?;
    value.is_finite().then(|| unit.to_si(value))
}

/// The centre of gravity in the tool frame, m, that a map gives for all rows; coordinates that it does not give are 0. None where it gives none.
pub(super) fn centre(map: &ColumnMap) -> Option<[f64; 3]> {
    let of = |name: &str| {
        let mut named = map.names.iter().chain(&map.usual_names).filter(|(ours, _)| ours == name);
        named.find_map(|(ours, theirs)| length((ours, theirs)))
    };
    let given = CENTRE.map(of);
    given.iter().any(Option::is_some).then(|| given.map(|value| value.unwrap_or(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_and_columns() {
        for (ours, theirs, expected) in [
            ("cz", "120mm", Some(0.12)),
            ("cz", "120 mm", Some(0.12)),
            ("cx", "-0.02[m]", Some(-0.02)),
            ("cy", "1.5e1 mm", Some(0.015)),
            ("cz", "120", None),
            ("cz", "120 kg", None),
            ("cz", "COG z[mm]", None),
            ("x", "120mm", None),
        ] {
            let found = length((ours, theirs));
            assert_eq!(
                found.map(|v| (1e9 * v).round()),
                expected.map(|v: f64| (1e9 * v).round()),
                "{theirs}"
            );
        }
        let names = vec![("cz".into(), "120mm".into()), ("cx".into(), "COG x[mm]".into())];
        assert_eq!(centre(&ColumnMap { names, ..ColumnMap::default() }), Some([0.0, 0.0, 0.12]));
        assert_eq!(centre(&ColumnMap::default()), None);
    }
}
