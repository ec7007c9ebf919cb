//! Name and unit of a header in our own spelling, `name[unit]`.

use crate::nearest::nearest;
use crate::table::unprefixed;
use crate::{Quantity, Unit};

/// Name and unit.
///
/// # Errors
/// What is wrong with the header.
pub(super) fn name_and_unit(header: &str) -> Result<(&str, Option<&str>), String> {
    let (name, unit) = match header.split_once('[') {
        None => (header.trim(), None),
        Some((name, rest)) => match rest.trim_end().strip_suffix(']') {
            Some(unit) if !unit.contains(['[', ']']) => (name.trim(), Some(unit.trim())),
            _ => return Err("a header is `name` or `name[unit]`; close the bracket at its end".into()),
        },
    };
    let name = unprefixed(name);
    if name.is_empty() {
        return Err("has no name; name the column in the header, or remove it".into());
    }
    if name.contains(']') {
        return Err("a header is `name` or `name[unit]`; open the bracket".into());
    }
    if unit == Some("") {
        return Err(format!("the unit is empty; write `{name}[1]` for a plain number"));
    }
    Ok((name, unit))
}

/// The unit of this word, of a column of this name and quantity.
///
/// # Errors
/// Why it cannot be that.
pub(super) fn unit_of(word: &str, name: &str, quantity: Quantity) -> Result<Unit, String> {
    let units = quantity.units().filter(|unit| *unit != "%").collect::<Vec<_>>();
    let listed = units.join(", ");
    match Unit::named(word) {
        Some(unit) if unit.quantity == quantity && word != "%" => Ok(*unit),
        Some(unit) => Err(format!(
            "[{word}] is the unit of {}, but `{name}` is {}; its unit can be: {listed}",
            unit.quantity.word(),
            quantity.word()
        )),
        None => {
            let lower = word.to_lowercase();
            let near = units.iter().find(|unit| unit.to_lowercase() == lower).copied();
            let hint = near.or_else(|| nearest(word, units.iter().copied()));
            let hint = hint.map_or(String::new(), |unit| format!("; did you mean [{unit}]?"));
            Err(format!(
                "unknown unit [{word}]{hint} (`{name}` is {}; its unit can be: {listed})",
                quantity.word()
            ))
        }
    }
}
