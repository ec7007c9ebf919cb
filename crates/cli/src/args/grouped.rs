//! How rows of measurements are grouped into pose measurements and configurations.

use truepose_errormodel::DwellTolerance;
use truepose_io::{MeasurementsOptions, Quantity, Unit};

/// How rows are grouped.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Grouped {
    /// Tolerance within which joint values belong to one dwell, and, ten times as wide, to repeats of one configuration: an angle for
    /// revolute joints, a length for prismatic joints, or both, e.g. 0.001deg or 0.001deg,20um; 0: exactly equal values
    /// [default: 1e-5rad,10um]
    #[arg(long, value_name = "ANGLE,LENGTH", allow_hyphen_values = true, value_parser = parse_tolerance)]
    pub dwell_tolerance: Option<DwellTolerance>,
}

impl Grouped {
    /// Options for measurements, which need a measured position or orientation.
    pub fn measured(&self) -> MeasurementsOptions {
        MeasurementsOptions {
            dwell: self.dwell_tolerance.unwrap_or_default(),
            ..MeasurementsOptions::default()
        }
    }

    /// Options for rows without measured values.
    pub fn conditions(&self) -> MeasurementsOptions {
        MeasurementsOptions { measured_required: false, ..self.measured() }
    }
}

/// `0.001deg`, `20um`, `0.001deg,20um`, `0`.
fn parse_tolerance(text: &str) -> Result<DwellTolerance, String> {
    let mut tolerance = DwellTolerance::default();
    if text.trim().parse::<f64>().is_ok_and(|v| v.abs() < f64::MIN_POSITIVE) {
        return Ok(DwellTolerance { angle: 0.0, length: 0.0 });
    }
    let (mut angle, mut length) = (None, None);
    for part in text.split(',').map(str::trim) {
        // The exponent of 1e-5rad is part of the number.
        let end = (0..=part.len())
            .rev()
            .filter(|&end| part.is_char_boundary(end))
            .find(|&end| part[..end].parse::<f64>().is_ok())
            .ok_or_else(|| format!("`{part}` is not a number with a unit"))?;
        let (number, word) = part.split_at(end);
        let value: f64 = number.parse().map_err(|_| format!("`{number}` is not a number"))?;
        let unit = Unit::named(word.trim());
        let slot = match unit.map(|unit| unit.quantity) {
            Some(Quantity::Angle) => &mut angle,
            Some(Quantity::Length) => &mut length,
            _ => {
                return Err("a tolerance needs a unit: rad, deg or mrad for revolute joints, m, mm or um for prismatic joints, as in 0.001deg".into());
            }
        };
        if !(value.is_finite() && value >= 0.0) {
            return Err("a tolerance is 0 or more".into());
        }
        if slot.replace(unit.map_or(value, |unit| unit.to_si(value))).is_some() {
            return Err("one angle and one length at most, as in 0.001deg,20um".into());
        }
    }
    tolerance.angle = angle.unwrap_or(tolerance.angle);
    tolerance.length = length.unwrap_or(tolerance.length);
    Ok(tolerance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_are_understood() {
        let of = |text: &str| parse_tolerance(text).map(|t| (t.angle, t.length));
        let near = |found: Result<(f64, f64), String>, angle: f64, length: f64| {
            let (a, l) = found.unwrap();
            assert!((a - angle).abs() < 1e-15 && (l - length).abs() < 1e-15, "{a} {l}");
        };
        near(of("0.001deg"), 1e-3f64.to_radians(), 1e-5);
        near(of("2e-5 rad, 20um"), 2e-5, 2e-5);
        near(of("0.02mm"), 1e-5, 2e-5);
        near(of("0"), 0.0, 0.0);
        near(of("0deg"), 0.0, 1e-5);
        for bad in ["0.001", "1kg", "deg", "-1deg", "nanrad", "infrad", "1deg,2deg", "1deg,", ""] {
            assert!(of(bad).is_err(), "{bad}");
        }
    }
}
