//! Parsers of option values with a unit or a format of their own.

use super::files::Prior;
use truepose_io::{Quantity, Unit};
use truepose_workflow::Units;
use truepose_workflow::text::length;
pub(super) use truepose_workflow::text::{position as parse_position, three as parse_three};

/// `evidence`, `none`, or κ.
pub(super) fn parse_prior(text: &str) -> Result<truepose_identify::PriorStrength, String> {
    use truepose_identify::PriorStrength;
    match text {
        "evidence" => Ok(PriorStrength::VarianceGroups),
        "none" => Ok(PriorStrength::None),
        _ => match text.parse::<f64>() {
            Ok(kappa) if kappa.is_finite() && kappa > 0.0 => Ok(PriorStrength::Fixed(kappa)),
            _ => Err("expected `evidence`, `none` or a number above 0".into()),
        },
    }
}

/// `evidence`, `none`, κ, or a file.
pub(super) fn parse_prior_or_fleet(text: &str) -> Result<Prior, String> {
    match parse_prior(text) {
        Ok(strength) => Ok(Prior::Sizes(strength)),
        Err(_) if text.to_lowercase().ends_with(".json") => Ok(Prior::Fleet(text.into())),
        Err(_) => {
            Err("expected `evidence`, `none`, a number above 0, or a file of `truepose fleet` (.json)".into())
        }
    }
}

/// `0.2` or `20%`.
pub(super) fn parse_fraction(text: &str) -> Result<f64, String> {
    let (number, divide) = match text.trim().strip_suffix('%') {
        Some(number) => (number.trim_end(), 100.0),
        None => (text.trim(), 1.0),
    };
    let fraction = number.parse::<f64>().map(|value| value / divide);
    fraction
        .ok()
        .filter(|value| value.is_finite())
        .ok_or_else(|| "a fraction is needed, as in 0.2 or 20%".into())
}

/// A whole number, such as a count or a seed.
pub(super) fn parse_whole<T: std::str::FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| "a whole number is needed, 0 or more".into())
}

/// As [`parse_whole`], of which there is one at least.
pub(super) fn parse_count(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|&count| count > 0).ok_or_else(|| "a whole number is needed, 1 or more".into())
}

/// `0.15mm`, `150um`, `0.006in`; metres.
pub(super) fn parse_length(text: &str) -> Result<f64, String> {
    let value = length(text)?;
    if value > 0.0 { Ok(value) } else { Err("a length above 0 is needed".into()) }
}

/// `2026-03-01`.
pub(super) fn parse_date(text: &str) -> Result<String, String> {
    let numbers: Vec<Option<u32>> = text.split('-').map(|part| part.parse().ok()).collect();
    let lengths: Vec<usize> = text.split('-').map(str::len).collect();
    match (numbers.as_slice(), lengths.as_slice()) {
        ([Some(_), Some(1..=12), Some(1..=31)], [4, 2, 2]) => Ok(text.to_owned()),
        _ => Err("a date is year-month-day, as in 2026-03-01".into()),
    }
}

/// `35ms`, `-0.1s`; seconds.
pub(super) fn parse_signed_time(text: &str) -> Result<f64, String> {
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let factor = match unit {
        "ms" => 1e-3,
        "s" => 1.0,
        _ => return Err("a time needs a unit: s or ms, as in 35ms".into()),
    };
    let value = number.trim().parse::<f64>().map(|value| factor * value);
    value.ok().filter(|value| value.is_finite()).ok_or_else(|| format!("`{number}` is not a number"))
}

/// `deg,mm`: one unit of an angle, one of a length, or either.
pub(super) fn parse_units(text: &str) -> Result<Units, String> {
    let mut units = Units::default();
    for word in text.split(',').map(str::trim) {
        let unit = Unit::named(word);
        let slot = match unit.map(|unit| unit.quantity) {
            Some(Quantity::Length) => &mut units.length,
            Some(Quantity::Angle) => &mut units.angle,
            _ => {
                return Err(format!(
                    "`{word}` is no unit of an angle (rad, deg) or a length (m, mm, um, in)"
                ));
            }
        };
        if std::mem::replace(slot, unit.copied()).is_some() {
            return Err("one unit of angles and one of lengths are possible, as in deg,mm".into());
        }
    }
    Ok(units)
}

/// `90s`, `10min`, `2h`.
pub(super) fn parse_time(text: &str) -> Result<std::time::Duration, String> {
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let factor = match unit {
        "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        _ => return Err("a time needs a unit: s, min or h, as in 10min".into()),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value * factor < 1e9 => {
            Ok(std::time::Duration::from_secs_f64(value * factor))
        }
        _ => Err(format!("`{number}` is no time above 0")),
    }
}

/// `500MB`, `2GB`; bytes.
pub(super) fn parse_memory(text: &str) -> Result<u64, String> {
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let factor = match unit {
        "MB" => 1e6,
        "GB" => 1e9,
        _ => return Err("a size needs a unit: MB or GB, as in 2GB".into()),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value * factor < 1e18 => Ok((value * factor) as u64),
        _ => Err(format!("`{number}` is no size above 0")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_with_their_units() {
        assert_eq!(parse_time("1.5min"), Ok(std::time::Duration::from_secs(90)));
        assert_eq!(parse_memory("0.5GB"), Ok(500_000_000));
        for bad in ["", "3", "s", "-1s", "nans", "1e30h", "3 weeks"] {
            assert!(parse_time(bad).is_err(), "{bad}");
        }
        for bad in ["", "3", "GB", "-1GB", "1e300MB", "3 bytes"] {
            assert!(parse_memory(bad).is_err(), "{bad}");
        }
    }
}
