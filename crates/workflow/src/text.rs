//! Numbers with units as people write them.

use truepose_io::{Quantity, Unit};

/// `0.15mm`, `-150um`, `0.006in`; metres.
///
/// # Errors
/// When it is no number with a unit of a length.
pub fn length(text: &str) -> Result<f64, String> {
    let split = text.find(|c: char| c.is_ascii_alphabetic() && c != 'e' && c != 'E').unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let value: f64 = number.trim().parse().map_err(|_| format!("`{number}` is not a number"))?;
    let unit = Unit::named(unit.trim())
        .filter(|unit| unit.quantity == Quantity::Length)
        .ok_or("a length needs a unit: m, mm, um or in, as in 0.15mm")?;
    if value.is_finite() { Ok(unit.to_si(value)) } else { Err("a finite length is needed".into()) }
}

/// `-500mm,0mm,0.2m`; metres.
///
/// # Errors
/// When there are not three lengths.
pub fn position(text: &str) -> Result<[f64; 3], String> {
    parts(text, length)
}

/// Three numbers.
///
/// # Errors
/// When there are not three finite numbers.
pub fn three(text: &str) -> Result<[f64; 3], String> {
    parts(text, |part| match part.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{part}` is not a number")),
    })
}

fn parts(text: &str, one: impl Fn(&str) -> Result<f64, String>) -> Result<[f64; 3], String> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    match parts[..] {
        [x, y, z] => Ok([one(x)?, one(y)?, one(z)?]),
        _ => Err(format!("three values with commas between them are needed, not {}", parts.len())),
    }
}
