//! How tables of measurements are read: which column is which, and which rows form a pose measurement.

use super::values::parse_whole;
use std::path::Path;
use truepose_errormodel::{DwellTolerance, FittedModel};
use truepose_io::{
    ColumnMap, IoError, MeasurementsOptions, OrientationConvention, Quantity, Unit, robot_columns,
};
use truepose_workflow::recorded_columns;

/// How rows are grouped.
#[derive(Debug, Clone, clap::Args)]
pub struct Grouped {
    /// Tolerance within which joint values belong to one dwell, and, ten times as wide, to repeats of one configuration: an angle for
    /// revolute joints, a length for prismatic joints, or both, e.g. 0.001deg or 0.001deg,20um; 0: exactly equal values
    /// [default: 1e-5rad,10um]
    #[arg(long, value_name = "ANGLE,LENGTH", allow_hyphen_values = true, value_parser = parse_tolerance)]
    pub dwell_tolerance: Option<DwellTolerance>,
    #[command(flatten)]
    pub named: NamedColumns,
}

/// Which column of a table is which.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct NamedColumns {
    /// A column of the data that holds a joint or another quantity under a name of its own, e.g. "A1=Joint 1[deg]"; repeat the option for
    /// each (or list them in [columns] of the robot file)
    #[arg(long, value_name = "NAME=COLUMN", value_parser = parse_map)]
    pub map: Vec<(String, String)>,
    /// A column of the data that is not read; repeat the option for each
    #[arg(long, value_name = "COLUMN")]
    pub ignore: Vec<String>,
    /// Lines of the data file that are not read, e.g. 89,202 (the header is a line, too: numbers as in messages)
    #[arg(long, value_name = "LINES", value_delimiter = ',', value_parser = parse_whole::<u64>)]
    pub exclude: Vec<u64>,
    /// Convention of measured orientations: rpy (roll pitch yaw, or rx ry rz, about fixed axes), abc (KUKA), wpr (FANUC), xyz (about
    /// moving axes), zyz (oat, Kawasaki), q1q2q3q4 (ABB), rotation_vector
    #[arg(long, value_name = "CONVENTION", value_parser = parse_orientation)]
    pub orientation: Option<OrientationConvention>,
}

impl NamedColumns {
    /// What the options say.
    pub fn map(&self) -> ColumnMap {
        ColumnMap {
            names: self.map.clone(),
            ignore: self.ignore.clone(),
            exclude: self.exclude.clone(),
            orientation: self.orientation,
            ..ColumnMap::default()
        }
        .asked()
        .with(&ColumnMap::default())
    }

    /// The same for another file of the robot of a fit, with the columns that its data had.
    pub fn map_for(&self, fitted: &FittedModel) -> ColumnMap {
        recorded_columns(fitted).with(&self.map())
    }
}

impl Grouped {
    /// Options for measurements, which need a measured position or orientation.
    pub fn measured(&self) -> MeasurementsOptions {
        MeasurementsOptions {
            dwell: self.dwell_tolerance.unwrap_or_default(),
            columns: self.named.map(),
            ..MeasurementsOptions::default()
        }
    }

    /// The same, with what the robot's file says about columns.
    pub fn measured_on(&self, robot: &Path) -> Result<MeasurementsOptions, IoError> {
        let own = self.measured();
        Ok(MeasurementsOptions { columns: robot_columns(robot)?.with(&own.columns), ..own })
    }

    /// The same, with the columns that the data of a fit had.
    pub fn measured_for(&self, fitted: &FittedModel) -> MeasurementsOptions {
        MeasurementsOptions { columns: self.named.map_for(fitted), ..self.measured() }
    }

    /// Options for rows without measured values, with the columns that the data of a fit had.
    pub fn conditions_for(&self, fitted: &FittedModel) -> MeasurementsOptions {
        MeasurementsOptions { measured_required: false, ..self.measured_for(fitted) }
    }
}

/// `A1=Joint 1[deg]`.
fn parse_map(text: &str) -> Result<(String, String), String> {
    match text.split_once('=').map(|(name, column)| (name.trim(), column.trim())) {
        Some((name, column)) if !name.is_empty() && !column.is_empty() => Ok((name.into(), column.into())),
        _ => Err("a name and a column of the data are needed, as in \"A1=Joint 1[deg]\"".into()),
    }
}

/// The word of a convention.
fn parse_orientation(text: &str) -> Result<OrientationConvention, String> {
    OrientationConvention::named(text).ok_or_else(|| {
        let known: Vec<&str> = OrientationConvention::WORDS.iter().map(|(word, _)| *word).collect();
        format!("unknown convention (known: {})", known.join(", "))
    })
}

/// `0.001deg`, `20um`, `0.001deg,20um`, `0`.
pub(super) fn parse_tolerance(text: &str) -> Result<DwellTolerance, String> {
    let mut tolerance = DwellTolerance::default();
    if text.trim().parse::<f64>().is_ok_and(|v| v.abs() < f64::MIN_POSITIVE) {
        return Ok(DwellTolerance { angle: 0.0, length: Some(0.0) });
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
    tolerance.length = length;
    Ok(tolerance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_are_understood() {
        let of = |text: &str| parse_tolerance(text).map(|t| (t.angle, t.length));
        let near = |found: Result<(f64, Option<f64>), String>, angle: f64, length: Option<f64>| {
            let (a, l) = found.unwrap();
            let same =
                l.is_some() == length.is_some() && (l.unwrap_or(0.0) - length.unwrap_or(0.0)).abs() < 1e-15;
            assert!((a - angle).abs() < 1e-15 && same, "{a} {l:?}");
        };
        near(of("0.001deg"), 1e-3f64.to_radians(), None);
        near(of("2e-5 rad, 20um"), 2e-5, Some(2e-5));
        near(of("0.02mm"), 1e-5, Some(2e-5));
        near(of("0"), 0.0, Some(0.0));
        near(of("0deg"), 0.0, None);
        for bad in ["0.001", "1kg", "deg", "-1deg", "nanrad", "infrad", "1deg,2deg", "1deg,", ""] {
            assert!(of(bad).is_err(), "{bad}");
        }
    }
}
