//! What a fit file says is checked before it is believed: people edit such files, and a number that no fit writes would pass into commands.

use crate::measurements::columns::Role;
use crate::measurements::header::MOST_COLUMNS;
use crate::robot::names::{cell_problem, joint_name_problem};
use truepose_errormodel::{CARRIED, ErrorModel, LoadCorrection};
use truepose_kinematics::Chain;
use truepose_kinematics::nalgebra::DMatrix;

/// A coefficient or a standard deviation beyond so many expected sizes is no result of a fit: a millimetre would be a thousand kilometres.
const ABSURD: f64 = 1e9;

/// Rounding that a covariance may have, in units of expected sizes and relative to its largest variance.
const ROUNDING: f64 = 1e-9;

/// Names as descriptions of robots have them.
pub(super) fn names(chain: &Chain) -> Result<(), String> {
    for (k, joint) in chain.joints().iter().enumerate() {
        if let Some(problem) = joint_name_problem(&joint.name) {
            return Err(format!("`robot.joints[{k}].name`: {problem}"));
        }
        if joint.link.is_some_and(|link| link.mass < 0.0) {
            return Err(format!("`robot.joints[{k}].link.mass` is below zero"));
        }
    }
    for (k, target) in chain.targets().iter().enumerate() {
        if let Some(problem) = cell_problem(&target.name) {
            return Err(format!("`robot.targets[{k}].name`: {problem}"));
        }
    }
    Ok(())
}

/// Coefficients of a size that a fit can have.
pub(super) fn coefficients(model: &ErrorModel, values: &[f64]) -> Result<(), String> {
    for (k, (column, value)) in model.columns().iter().zip(values).enumerate() {
        if value.abs() > ABSURD * column.scale {
            return Err(format!("`coefficients[{k}].value`: `{}` is {value:e} {}", column.name, column.unit));
        }
    }
    Ok(())
}

/// A covariance: symmetric, and no direction with a variance below zero, both up to rounding.
pub(super) fn covariance(model: &ErrorModel, covariance: &DMatrix<f64>) -> Result<(), String> {
    let columns = model.columns();
    let size = covariance.nrows().min(columns.len());
    // In units of expected sizes.
    let mut scaled =
        DMatrix::from_fn(size, size, |i, j| covariance[(i, j)] / (columns[i].scale * columns[j].scale));
    let largest = scaled.diagonal().iter().copied().fold(1.0, f64::max);
    for k in 0..size {
        let variance = covariance[(k, k)];
        let problem = match scaled[(k, k)] {
            v if v < -ROUNDING * largest => "below zero",
            v if !v.is_finite() || v > ABSURD * ABSURD => "too large",
            _ => continue,
        };
        return Err(format!(
            "`covariance[{k}][{k}]`: the variance of `{}` is {variance:e}, {problem}",
            columns[k].name
        ));
    }
    for i in 0..size {
        for j in 0..i {
            let bound =
                ROUNDING * (scaled[(i, i)].abs() * scaled[(j, j)].abs()).sqrt() + f64::EPSILON * largest;
            let differs = (scaled[(i, j)] - scaled[(j, i)]).abs() <= bound;
            if !differs {
                let (a, b) = (covariance[(i, j)], covariance[(j, i)]);
                return Err(format!(
                    "`covariance[{i}][{j}]` is {a:e}, but `covariance[{j}][{i}]` is {b:e}: not symmetric"
                ));
            }
        }
    }
    // Directions: a factor exists when none is below zero by more than rounding.
    (0..size).for_each(|k| scaled[(k, k)] += ROUNDING * largest * size as f64);
    match scaled.cholesky() {
        Some(_) => Ok(()),
        None => {
            Err("`covariance` is not one: the variance of a combination of coefficients is below zero".into())
        }
    }
}

/// Ranges of a domain, lower and upper.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ranges<'f> {
    pub joints: &'f [[f64; 2]],
    pub channels: &'f [[f64; 2]],
    pub payload: Option<[f64; 2]>,
    pub time: Option<[f64; 2]>,
}

/// Ranges that ascend, one for each joint and channel, or none at all.
pub(super) fn domain(domain: Ranges<'_>, chain: &Chain, channels: usize) -> Result<(), String> {
    let lists = [("joints", domain.joints, chain.movable().len()), ("channels", domain.channels, channels)];
    for (key, list, need) in lists {
        if !list.is_empty() && list.len() != need {
            return Err(format!("`domain.{key}` has {} ranges, not {need}", list.len()));
        }
        for (k, range) in list.iter().enumerate() {
            ascending(&format!("domain.{key}[{k}]"), range)?;
        }
    }
    for (key, range) in [("payload", domain.payload), ("time", domain.time)] {
        range.as_ref().map_or(Ok(()), |range| ascending(&format!("domain.{key}"), range))?;
    }
    match domain.payload {
        Some([lower, _]) if lower < 0.0 => Err(format!("`domain.payload` begins at {lower} kg, below zero")),
        _ => Ok(()),
    }
}

fn ascending(key: &str, [lower, upper]: &[f64; 2]) -> Result<(), String> {
    if lower <= upper { Ok(()) } else { Err(format!("`{key}` is reversed: [{lower}, {upper}]")) }
}

/// Masses, and no level twice.
pub(super) fn loads(loads: &[LoadCorrection]) -> Result<(), String> {
    for (k, load) in loads.iter().enumerate() {
        for (key, mass) in [("declared", load.declared), ("carried", load.carried)] {
            if mass < 0.0 {
                return Err(format!("`loads[{k}].{key}` is {mass} kg, below zero"));
            }
        }
        let ascends = |[from, until]: [f64; 2]| from < until;
        if let Some([from, until]) = load.during.filter(|during| !ascends(*during)) {
            return Err(format!("`loads[{k}].during` is reversed: [{from}, {until}]"));
        }
        let same = |other: &LoadCorrection| {
            other.declared.total_cmp(&load.declared).is_eq() && other.during == load.during
        };
        if loads[..k].iter().any(same) {
            return Err(format!("`loads[{k}].declared`: {} kg stands twice", load.declared));
        }
    }
    Ok(())
}

/// Key of the channels of a sample's rows.
pub(super) const SAMPLED: &str = "sample_of.channels";

/// Channels as a table of measurements can have them.
pub(super) fn channels<'c>(
    key: &str,
    names: impl Iterator<Item = &'c str>,
    chain: &Chain,
) -> Result<(), String> {
    let mut seen = std::collections::HashSet::new();
    for (k, name) in names.enumerate() {
        if k == MOST_COLUMNS {
            return Err(format!(
                "`{key}` has more channels than a table of measurements has columns ({MOST_COLUMNS})"
            ));
        }
        let problem = match Role::of(name, chain, 0) {
            Ok(Role::Channel(_)) if name.is_empty() => "it has no name",
            Ok(Role::Channel(_)) if !seen.insert(name) => "the name stands twice",
            Ok(Role::Channel(_)) => continue,
            // Rows of a sample keep the mass that they carry beside the payload that it comes from.
            _ if name == CARRIED && key == SAMPLED && seen.insert(name) => continue,
            _ => "a channel cannot bear the name of a joint, or of another column of measurements",
        };
        return Err(format!("`{key}[{k}].name`: `{}`: {problem}", name.escape_debug()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_sample_has_the_mass_that_it_carries_among_its_channels() {
        let chain = truepose_kinematics::samples::ur10();
        let of = |key: &str, names: &[&str]| channels(key, names.iter().copied(), &chain);
        assert_eq!(of(SAMPLED, &["temperature", CARRIED]), Ok(()));
        assert!(of(SAMPLED, &[CARRIED, CARRIED]).is_err());
        let refused = of("channels", &[CARRIED]).unwrap_err();
        assert!(refused.starts_with("`channels[0].name`: `payload`: a channel cannot bear"), "{refused}");
    }
}
