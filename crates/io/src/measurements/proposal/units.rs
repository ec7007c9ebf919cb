//! Units that values show.

use super::super::columns::{Column, Role, joint_quantity};
use super::super::plausible::Plausible;
use super::super::sampled::Sample;
use super::seen::Seen;
use crate::{Quantity, Unit};
use std::f64::consts::PI;
use truepose_kinematics::Chain;

/// Nobody writes angles of an orientation beyond two turns.
const TWO_TURNS: f64 = 4.0 * PI;

/// Positions spread over more than this many lengths of the robot are in another unit.
const TOO_FAR: f64 = 20.0;

/// The unit of a joint whose header has none, from the values of all of these columns of its kind.
pub(super) fn of_joints(
    seen: &[Seen<'_>],
    columns: &[usize],
    chain: &Chain,
    joint: usize,
) -> Option<&'static Unit> {
    let quantity = joint_quantity(chain, joint);
    let unit = |word: &str| Unit::named(word);
    let most = |&k: &usize| seen[k].range().map_or(0.0, |(low, high)| low.abs().max(high.abs()));
    match quantity {
        Quantity::Angle => {
            let rows = columns.iter().any(|&k| seen[k].range().is_some());
            let most = columns.iter().filter(|&&k| seen[k].unit.is_none()).map(most).fold(0.0, f64::max);
            let turns = if most > 7.0 { "deg" } else { "rad" };
            rows.then(|| unit(turns)).flatten()
        }
        _ => {
            let plausible = Plausible::of(chain, chain.movable()[joint]);
            let (low, high) = columns.get(joint).and_then(|&k| seen[k].range())?;
            let inside = |factor: f64| factor * low >= plausible.lower && factor * high <= plausible.upper;
            match (plausible.upper.is_finite(), inside(1.0), inside(1e-3)) {
                (true, true, _) => unit("m"),
                (true, false, true) => unit("mm"),
                _ => None,
            }
        }
    }
}

/// The unit of positions whose headers have none.
pub(super) fn of_places(seen: &[Seen<'_>], columns: &[usize], chain: &Chain) -> Option<&'static Unit> {
    let spread = |&k: &usize| seen[k].range().map(|(low, high)| high - low);
    let spreads: Option<Vec<f64>> = columns.iter().map(spread).collect();
    let spread = spreads?.into_iter().fold(0.0, f64::hypot);
    let length = chain.characteristic_length();
    // 1 mm and 1 m of one robot are a factor of a thousand apart.
    Unit::named(if spread > TOO_FAR * length { "mm" } else { "m" }).filter(|_| spread > 1e-3 * length)
}

/// The unit of angles whose headers have none.
pub(super) fn of_angles(seen: &[Seen<'_>], columns: &[usize]) -> Option<&'static Unit> {
    let most = |&k: &usize| seen[k].range().map(|(low, high)| low.abs().max(high.abs()));
    let all: Option<Vec<f64>> = columns.iter().map(most).collect();
    Unit::named(if all?.into_iter().fold(0.0, f64::max) > 7.0 { "deg" } else { "rad" })
}

/// Why the values of a column cannot be meant in its unit: an orientation's angles in rad that are degrees.
pub(in super::super) fn impossible(column: &Column, sample: &Sample, k: usize) -> Option<String> {
    if !matches!(column.role, Role::Angle(_) | Role::RotationVector(_)) || column.unit != "rad" {
        return None;
    }
    let value =
        sample.cells(k).filter_map(|cell| cell.parse::<f64>().ok()).find(|value| value.abs() > TWO_TURNS)?;
    let assumed = if column.unit_given { "" } else { " (assumed: the header has no unit)" };
    Some(format!(
        "{value} rad{assumed} is beyond any plausible turn, and looks like degrees; if so, call the column `{}[deg]`",
        column.name
    ))
}
